#pragma once

#include <string>

namespace morphograph::testing {

/// A few characters a frame that claim `joints` rotations each: only the root has a channel.
inline std::string ManyJointsWithoutChannels(int joints, int frames, const std::string& frame_time = "0.01") {
  std::string text = "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n";
  for (int j = 1; j < joints; ++j) text += "JOINT j" + std::to_string(j) + "\n{\nOFFSET 0 1 0\n}\n";
  text += "}\nMOTION\nFrames: " + std::to_string(frames) + "\nFrame Time: " + frame_time + "\n";
  for (int f = 0; f < frames; ++f) text += "0\n";
  return text;
}

/// A legged figure with a mixed rotation order, a 6-channel child, a one-axis child and a leaf without End Site.
inline constexpr char kSmallBvh[] =
    "HIERARCHY\n"
    "ROOT Hips\n{\n  OFFSET 0 0 0\n  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
    "  JOINT LeftUpLeg\n  {\n    OFFSET 10 -5 0\n    CHANNELS 3 Xrotation Yrotation Zrotation\n"
    "    JOINT LeftLeg\n    {\n      OFFSET 0 -40 0\n      CHANNELS 1 Xrotation\n"
    "      JOINT LeftFoot\n      {\n        OFFSET 0 -42 0\n        CHANNELS 3 Yrotation Zrotation Xrotation\n"
    "        End Site\n        {\n          OFFSET 0 -6 14\n        }\n      }\n    }\n  }\n"
    "  JOINT RightUpLeg\n  {\n    OFFSET 99 99 99\n"
    "    CHANNELS 6 Xposition Yposition Zposition Yrotation Xrotation Zrotation\n"
    "    JOINT RightFoot\n    {\n      OFFSET 0 -82 0\n      CHANNELS 3 Zrotation Yrotation Xrotation\n    }\n  }\n"
    "}\n"
    "MOTION\nFrames: 3\nFrame Time: 0.0083333\n"
    "1 95 2 10 20 30 5 6 7 12 1 2 3 -10 -5 0 4 5 6 7 8 9\n"
    "2 96 3 11 21 31 6 7 8 13 2 3 4 -10 -5 0 5 6 7 8 9 10\n"
    "3 97 4 12 22 32 7 8 9 14 3 4 5 -10 -5 0 6 7 8 9 10 11\n";

}  // namespace morphograph::testing
