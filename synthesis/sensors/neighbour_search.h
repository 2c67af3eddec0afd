#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <vector>

namespace morphograph {

struct Neighbour {
  float squared_distance = 0;
  int index = 0;  // column of the points

  /// By distance; of equally near ones the one of the lower index first.
  bool operator<(const Neighbour& other) const {
    return squared_distance != other.squared_distance ? squared_distance < other.squared_distance : index < other.index;
  }
};

/// Exact search for the K nearest of many points of few dimensions, for K in the thousands.
///
/// A kd-tree (nanoflann) over a copy of the points that lies in the order of its leaves, so that a leaf is read in one go. What it finds
/// is gathered in a buffer that is cut back to the K nearest whenever it holds twice as many: a constant cost a point found, where
/// keeping them sorted costs K and a heap log K.
///
/// Immutable; may be asked by several threads.
class NeighbourSearch {
 public:
  /// @param points  (dims x count), both at least 1; copied.
  /// @throws std::invalid_argument for no points, or a value that is not finite.
  explicit NeighbourSearch(const Eigen::MatrixXf& points);
  ~NeighbourSearch();
  NeighbourSearch(NeighbourSearch&&) noexcept;
  NeighbourSearch& operator=(NeighbourSearch&&) noexcept;

  int size() const;

  /// The `count` nearest points (all of them when there are fewer), in no particular order.
  /// @param query  (dims).
  /// @param bound  a squared distance that the count-th nearest is known not to exceed: the search then starts with it. What is farther is
  ///   not found, so that a bound that is too low gives fewer points.
  /// @param found  is overwritten; kept by the caller to spare its memory being had anew.
  /// @throws std::invalid_argument for a query of another size or that is not finite, or a count below 1.
  void Nearest(const Eigen::VectorXf& query, int count, std::vector<Neighbour>* found,
               float bound = std::numeric_limits<float>::infinity()) const;

  /// Memory of the tree and its copy of the points.
  std::size_t memory_bytes() const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace morphograph
