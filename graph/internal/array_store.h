#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace morphograph::internal {

/// Collects matrices for a model file: little-endian, column-major, one after the other; JSON descriptors say where.
///
/// A descriptor is {"at": byte offset, "rows": r, "cols": c, "type": "f64" | "f32" | "i16"}. Of "i16", a column is its scale as f32, a power of two
/// (value = integer * scale), the r integers, and the columns follow each other; used where 15 bits of the largest value are plenty.
class ArrayWriter {
 public:
  nlohmann::json Doubles(const Eigen::MatrixXd& matrix);
  nlohmann::json Floats(const Eigen::MatrixXf& matrix);
  nlohmann::json Shorts(const Eigen::MatrixXf& matrix);
  const std::string& bytes() const { return bytes_; }

 private:
  nlohmann::json Descriptor(Eigen::Index rows, Eigen::Index cols, const char* type) const;
  template <typename T>
  void Append(T value);
  std::string bytes_;
};

/// Reads what ArrayWriter wrote. Every descriptor is checked against the bytes before memory is asked for.
/// @throws std::runtime_error on a descriptor that does not fit; nlohmann's exceptions on missing fields.
class ArrayReader {
 public:
  explicit ArrayReader(std::string_view bytes) : bytes_(bytes) {}
  Eigen::MatrixXd Doubles(const nlohmann::json& descriptor) const;
  Eigen::MatrixXf Floats(const nlohmann::json& descriptor) const;  // of "f32" and "i16"

 private:
  std::string_view bytes_;
};

}  // namespace morphograph::internal
