#pragma once

#include <atomic>
#include <string>

#include "api/problem.h"

namespace morphograph::internal {

/// How many answers of a kind may be held at a time: those that cost memory or work after their handler has returned.
class LimitedPlaces {
 public:
  /// @param when_full  what is said (503, Retry-After) to those that come when all places are taken.
  LimitedPlaces(int most, std::string when_full) : most_(most), when_full_(std::move(when_full)) {}

  /// One of the places; kept until the answer is out. @throws ProblemError 503 where none is left.
  class Place {
   public:
    explicit Place(LimitedPlaces* places) : places_(places) {
      if (++places_->held_ <= places_->most_) return;
      --places_->held_;
      throw ProblemError(Problem{503, places_->when_full_, {}, 5, {}});
    }
    ~Place() { --places_->held_; }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

   private:
    LimitedPlaces* places_;
  };

 private:
  const int most_;
  const std::string when_full_;
  std::atomic<int> held_ = 0;
};

}  // namespace morphograph::internal
