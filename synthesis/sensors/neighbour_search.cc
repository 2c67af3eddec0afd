#include "synthesis/sensors/neighbour_search.h"

#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>
#include <stdexcept>
#include <string>

namespace morphograph {
namespace {

constexpr int kPacket = 4;  // floats that every processor takes at once
constexpr std::size_t kLeafSize = 160;

// Points in columns, padded with zeros to whole packets.
struct PointStore {
  Eigen::MatrixXf points;
  int dims = 0;  // without the padding

  std::size_t kdtree_get_point_count() const { return static_cast<std::size_t>(points.cols()); }
  float kdtree_get_pt(std::size_t index, std::size_t dim) const { return points(static_cast<Eigen::Index>(dim), static_cast<Eigen::Index>(index)); }
  template <class Box>
  bool kdtree_get_bbox(Box&) const { return false; }
};

// Squared distance, packet by packet.
struct PacketDistance {
  using ElementType = float;
  using DistanceType = float;
  const PointStore& store;

  explicit PacketDistance(const PointStore& points) : store(points) {}
  float evalMetric(const float* a, std::uint32_t index, std::size_t) const {
    using Packet = Eigen::Array<float, kPacket, 1>;
    const Eigen::Index rows = store.points.rows();
    const float* b = store.points.data() + static_cast<Eigen::Index>(index) * rows;
    Packet sum = Packet::Zero();
    for (Eigen::Index r = 0; r < rows; r += kPacket)
      sum += (Eigen::Map<const Packet>(a + r) - Eigen::Map<const Packet>(b + r)).square();
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }
  template <typename U, typename V>
  float accum_dist(const U a, const V b, std::size_t) const { return (a - b) * (a - b); }
};

using KdTree = nanoflann::KDTreeSingleIndexAdaptor<PacketDistance, PointStore, -1, std::uint32_t>;

// Keeps at least the nearest `count` of what it is offered, and at most twice as many.
class NearestBuffer {
 public:
  using DistanceType = float;
  NearestBuffer(std::size_t count, float bound, const std::vector<int>& column_of, std::vector<Neighbour>* found)
      : count_(count), bound_(bound), column_of_(column_of), found_(*found) {
    found_.clear();
    found_.reserve(2 * count);
  }
  bool addPoint(float distance, std::uint32_t index) {
    if (distance > bound_) return true;
    found_.push_back({distance, column_of_[index]});
    if (found_.size() == 2 * count_) {
      Cut();
      bound_ = found_[count_ - 1].squared_distance;
    }
    return true;
  }
  // What is as far as the bound is still wanted, for it may have a lower index.
  float worstDist() const { return std::nextafter(bound_, std::numeric_limits<float>::infinity()); }
  bool full() const { return found_.size() >= count_; }
  std::size_t size() const { return found_.size(); }
  void Cut() {
    if (found_.size() <= count_) return;
    std::nth_element(found_.begin(), found_.begin() + static_cast<std::ptrdiff_t>(count_ - 1), found_.end());
    found_.resize(count_);
  }

 private:
  std::size_t count_;
  float bound_;
  const std::vector<int>& column_of_;  // the caller's indices decide between equals
  std::vector<Neighbour>& found_;
};

}  // namespace

struct NeighbourSearch::Tree {
  PointStore store;
  std::unique_ptr<KdTree> index;
  std::vector<int> column_of;  // of the caller's points, by place in the store
};

NeighbourSearch::NeighbourSearch(const Eigen::MatrixXf& points) : tree_(std::make_unique<Tree>()) {
  if (points.size() == 0) throw std::invalid_argument("NeighbourSearch: there are no points");
  if (!points.allFinite()) throw std::invalid_argument("NeighbourSearch: a point is not finite");
  PointStore& store = tree_->store;
  store.dims = static_cast<int>(points.rows());
  store.points = Eigen::MatrixXf::Zero((points.rows() + kPacket - 1) / kPacket * kPacket, points.cols());
  store.points.topRows(points.rows()) = points;
  tree_->index = std::make_unique<KdTree>(store.dims, store, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize));
  // The tree knows points by its table of them; sorting both by it turns the table into 0, 1, 2, …
  std::vector<std::uint32_t>& order = tree_->index->vAcc;
  tree_->column_of.assign(order.begin(), order.end());
  Eigen::MatrixXf sorted(store.points.rows(), store.points.cols());
  for (std::size_t i = 0; i < order.size(); ++i) {
    sorted.col(static_cast<Eigen::Index>(i)) = store.points.col(order[i]);
    order[i] = static_cast<std::uint32_t>(i);
  }
  store.points = std::move(sorted);
}

NeighbourSearch::~NeighbourSearch() = default;
NeighbourSearch::NeighbourSearch(NeighbourSearch&&) noexcept = default;
NeighbourSearch& NeighbourSearch::operator=(NeighbourSearch&&) noexcept = default;

int NeighbourSearch::size() const { return static_cast<int>(tree_->column_of.size()); }

std::size_t NeighbourSearch::memory_bytes() const {
  return tree_->index->usedMemory(*tree_->index) + sizeof(float) * static_cast<std::size_t>(tree_->store.points.size()) +
         sizeof(int) * tree_->column_of.size();
}

void NeighbourSearch::Nearest(const Eigen::VectorXf& query, int count, std::vector<Neighbour>* found, float bound) const {
  if (query.size() != tree_->store.dims) {
    throw std::invalid_argument("NeighbourSearch: expected " + std::to_string(tree_->store.dims) + " values, got " +
                                std::to_string(query.size()));
  }
  if (!query.allFinite()) throw std::invalid_argument("NeighbourSearch: the query is not finite");
  if (count < 1) throw std::invalid_argument("NeighbourSearch: asked for no neighbour");
  Eigen::VectorXf padded = Eigen::VectorXf::Zero(tree_->store.points.rows());
  padded.head(query.size()) = query;
  NearestBuffer buffer(static_cast<std::size_t>(std::min(count, size())), bound, tree_->column_of, found);
  tree_->index->findNeighbors(buffer, padded.data(), nanoflann::SearchParams());
  buffer.Cut();
}

}  // namespace morphograph
