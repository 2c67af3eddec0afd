#pragma once

#include <string_view>

/// Defines `static std::string_view name()` with the bytes of a file, taken in by the assembler as they are. Labels are
/// global, because link-time optimisation may move their users into other units. `file` is a string literal.
#define MORPHOGRAPH_EMBED_FILE(name, file)                                                                   \
  asm(".pushsection .rodata\n"                                                                               \
      ".global morphograph_file_" #name "_begin\n.global morphograph_file_" #name "_end\n"                   \
      ".balign 16\nmorphograph_file_" #name "_begin:\n.incbin \"" file "\"\n"                                \
      "morphograph_file_" #name "_end:\n.byte 0\n.popsection\n");                                            \
  extern "C" const char morphograph_file_##name##_begin[];                                                   \
  extern "C" const char morphograph_file_##name##_end[];                                                     \
  static std::string_view name() {                                                                           \
    return {morphograph_file_##name##_begin,                                                                 \
            static_cast<std::size_t>(morphograph_file_##name##_end - morphograph_file_##name##_begin)};      \
  }
