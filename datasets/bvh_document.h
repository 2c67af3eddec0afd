#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/skeleton.h"

namespace morphograph {

/// How BVH names the channels, in the order of `Channel`.
inline constexpr std::array<std::string_view, 6> kBvhChannelWords = {"Xposition", "Yposition", "Zposition",
                                                                      "Xrotation", "Yrotation", "Zrotation"};

/// A BVH file as it stands: source units, source axes, source channel order; degrees.
struct BvhDocument {
  struct Node {
    std::string name;
    int parent = -1;
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();
    std::optional<Eigen::Vector3d> end_site;
    std::vector<Channel> channels;
    int first_channel = 0;  // row of `values` where this joint's channels start
  };
  std::vector<Node> nodes;  // parents before children, file order
  double frame_time_s = 0;
  Eigen::MatrixXd values;  // (channels x frames)
  std::string source;      // file name, for messages
  bool names_transcoded = false;  // some were no UTF-8 and have been read as Latin-1

  int channel_count() const { return static_cast<int>(values.rows()); }
  int frame_count() const { return static_cast<int>(values.cols()); }
};

}  // namespace morphograph
