#pragma once

namespace morphograph {

/// Work that may go into one request, counted in a way that does not depend on the machine: a unit is about what it takes to evaluate one term of
/// one step with its derivatives, some 10 microseconds.
class SteerBudget {
 public:
  explicit SteerBudget(double units) : left_(units) {}
  void Take(double units) { left_ -= units; }
  bool spent() const { return left_ <= 0; }
  double left() const { return left_; }

 private:
  double left_;
};

}  // namespace morphograph
