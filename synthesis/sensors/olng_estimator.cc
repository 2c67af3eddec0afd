#include "synthesis/sensors/olng_estimator.h"

#include <utility>

namespace morphograph {

OlngEstimator::OlngEstimator(std::shared_ptr<const OlngModel> model)
    : model_(std::move(model)), graph_(model_->Follows(TimeDirection::kForwards), model_->options().graph), neighbours_(model_) {
  if (model_->options().pose != OlngPose::kNearest) poser_.emplace(model_);
}

BasePose OlngEstimator::Next(const Eigen::VectorXd& reading) {
  model_->Check(reading);
  if (poser_) return poser_->Next(reading, graph_.Update(neighbours_.Next(reading)));
  std::vector<Neighbour> nearest;
  model_->search().Nearest(model_->scale().cwiseProduct(reading.cast<float>()), 1, &nearest);
  return model_->base().Pose(nearest.front().index);
}

}  // namespace morphograph
