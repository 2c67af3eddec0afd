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

/// The clips made lately, by id. A clip is a function of model and request, so only those are kept and the clip is made again when
/// somebody asks. Bounded in number and in bytes, since a request may hold a long path: those unused for longest go first. Safe from any
/// thread.
class ClipStore {
 public:
  struct Entry {
    ClipRequest request;  // seed set
    std::shared_ptr<const ServedModel> model;
  };

  explicit ClipStore(std::size_t capacity = 10'000, std::size_t capacity_bytes = std::size_t{64} << 20)
      : capacity_(capacity), capacity_bytes_(capacity_bytes) {}

  void Put(const std::string& id, Entry entry);
  std::optional<Entry> Get(const std::string& id);
  std::size_t size() const;
  std::size_t bytes() const;

 private:
  struct Item {
    std::string id;
    Entry entry;
    std::size_t bytes;  // about
  };
  const std::size_t capacity_;
  const std::size_t capacity_bytes_;
  std::size_t bytes_ = 0;
  mutable std::mutex mutex_;
  std::list<Item> by_use_;  // latest first
  std::unordered_map<std::string, std::list<Item>::iterator> by_id_;
};

}  // namespace morphograph
