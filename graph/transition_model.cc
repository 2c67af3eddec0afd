#include "graph/transition_model.h"

namespace morphograph {

Eigen::VectorXd TransitionModel::Mean(const Eigen::VectorXd& whitened) const {
  Eigen::VectorXd mean = (linear * whitened.cast<float>()).cast<double>();
  if (process) mean += process->PredictMean(whitened);
  return mean;
}

}  // namespace morphograph
