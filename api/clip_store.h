#pragma once

#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>

#include "api/clip_request.h"
#include "api/model_registry.h"

namespace morphograph {

/// The clips made lately, by id. A clip is a function of model and request, so only those are kept (under a kilobyte each)
/// and the clip is made again when somebody asks. Bounded: the one unused for longest goes first. Safe from any thread.
class ClipStore {
 public:
  struct Entry {
    ClipRequest request;  // seed set
    std::shared_ptr<const ServedModel> model;
  };

  explicit ClipStore(std::size_t capacity = 10'000) : capacity_(capacity) {}

  void Put(const std::string& id, Entry entry);
  std::optional<Entry> Get(const std::string& id);
  std::size_t size() const;

 private:
  using Item = std::pair<std::string, Entry>;
  const std::size_t capacity_;
  mutable std::mutex mutex_;
  std::list<Item> by_use_;  // latest first
  std::unordered_map<std::string, std::list<Item>::iterator> by_id_;
};

}  // namespace morphograph
