#include "graph/internal/array_store.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>

namespace morphograph::internal {
namespace {

static_assert(std::endian::native == std::endian::little, "model files are little-endian, as is every machine built for so far");

constexpr float kLargestShort = 32767;

template <typename T>
T Take(const char*& at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  at += sizeof value;
  return value;
}

struct Placed {
  const char* at;
  Eigen::Index rows, cols;
};

Placed Place(std::string_view bytes, const nlohmann::json& descriptor, std::uint64_t value_bytes, std::uint64_t column_bytes) {
  const auto at = descriptor.at("at").get<std::uint64_t>();
  const auto rows = descriptor.at("rows").get<std::uint64_t>();
  const auto cols = descriptor.at("cols").get<std::uint64_t>();
  constexpr std::uint64_t kMost = 1u << 28;
  if (rows > kMost || cols > kMost || at > bytes.size() || rows * cols > kMost ||
      (rows * value_bytes + column_bytes) * cols > bytes.size() - at) {
    throw std::runtime_error("an array reaches beyond the file");
  }
  return {bytes.data() + at, static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(cols)};
}

void RequireType(const nlohmann::json& descriptor, std::string_view type) {
  if (descriptor.at("type").get<std::string>() != type) throw std::runtime_error("an array has an unexpected type");
}

}  // namespace

template <typename T>
void ArrayWriter::Append(T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes_.append(raw, sizeof value);
}

nlohmann::json ArrayWriter::Descriptor(Eigen::Index rows, Eigen::Index cols, const char* type) const {
  return {{"at", bytes_.size()}, {"rows", rows}, {"cols", cols}, {"type", type}};
}

nlohmann::json ArrayWriter::Doubles(const Eigen::MatrixXd& matrix) {
  nlohmann::json descriptor = Descriptor(matrix.rows(), matrix.cols(), "f64");
  for (Eigen::Index i = 0; i < matrix.size(); ++i) Append(matrix.data()[i]);
  return descriptor;
}

nlohmann::json ArrayWriter::Floats(const Eigen::MatrixXf& matrix) {
  nlohmann::json descriptor = Descriptor(matrix.rows(), matrix.cols(), "f32");
  for (Eigen::Index i = 0; i < matrix.size(); ++i) Append(matrix.data()[i]);
  return descriptor;
}

nlohmann::json ArrayWriter::Shorts(const Eigen::MatrixXf& matrix) {
  nlohmann::json descriptor = Descriptor(matrix.rows(), matrix.cols(), "i16");
  for (Eigen::Index c = 0; c < matrix.cols(); ++c) {
    const float largest = matrix.rows() > 0 ? matrix.col(c).cwiseAbs().maxCoeff() : 0;
    // A power of two: products are then exact, and what was read is written again to the same bytes.
    float scale = 1;
    if (largest > 0) {
      int exponent = 0;
      std::frexp(largest / kLargestShort, &exponent);
      scale = std::ldexp(1.0f, exponent);
    }
    Append(scale);
    for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
      Append(static_cast<std::int16_t>(std::lround(matrix(r, c) / scale)));
    }
  }
  return descriptor;
}

Eigen::MatrixXd ArrayReader::Doubles(const nlohmann::json& descriptor) const {
  RequireType(descriptor, "f64");
  const Placed placed = Place(bytes_, descriptor, sizeof(double), 0);
  Eigen::MatrixXd matrix(placed.rows, placed.cols);
  if (matrix.size() > 0) std::memcpy(matrix.data(), placed.at, sizeof(double) * matrix.size());
  if (!matrix.allFinite()) throw std::runtime_error("an array holds values that are not finite");
  return matrix;
}

Eigen::MatrixXf ArrayReader::Floats(const nlohmann::json& descriptor) const {
  const bool shorts = descriptor.at("type").get<std::string>() == "i16";
  if (!shorts) RequireType(descriptor, "f32");
  const Placed placed = shorts ? Place(bytes_, descriptor, sizeof(std::int16_t), sizeof(float))
                               : Place(bytes_, descriptor, sizeof(float), 0);
  Eigen::MatrixXf matrix(placed.rows, placed.cols);
  const char* at = placed.at;
  for (Eigen::Index c = 0; c < placed.cols; ++c) {
    const float scale = shorts ? Take<float>(at) : 1;
    for (Eigen::Index r = 0; r < placed.rows; ++r) {
      matrix(r, c) = shorts ? scale * static_cast<float>(Take<std::int16_t>(at)) : Take<float>(at);
    }
  }
  if (!matrix.allFinite()) throw std::runtime_error("an array holds values that are not finite");
  return matrix;
}

}  // namespace morphograph::internal
