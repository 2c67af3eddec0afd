#pragma once

namespace morphograph::testing {

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
