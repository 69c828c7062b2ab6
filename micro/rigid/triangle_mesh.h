#pragma once
/// \file
/// Closed surfaces of triangles, as other programs write them, and what of them is nearest to a point.

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <vector>

#include "micro/core/types.h"

namespace trame::micro {

/// What is wrong with triangles, in words that follow a name of theirs.
class MeshError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Triangles {
  std::vector<Vec3> points;
  std::vector<std::array<Index, 3>> corners;  ///< of each triangle, in `points`

  bool operator==(const Triangles&) const = default;
};

/// Triangles by their corners; those that coincide become one point. Throws MeshError.
[[nodiscard]] Triangles joined(const std::vector<std::vector<Vec3>>& triangles);
/// Triangles of a file: STL (text or binary), OBJ, OFF or PLY, told by the end of its name; points that coincide become
/// one. Throws MeshError.
[[nodiscard]] Triangles read_triangles(const std::filesystem::path& file);

/// A surface that encloses a volume and does not cut itself.
class TriangleMesh {
 public:
  /// Throws MeshError where the triangles are no such surface; which way round they are does not matter.
  explicit TriangleMesh(Triangles triangles);

  [[nodiscard]] const Triangles& triangles() const { return triangles_; }

  enum class Feature : std::uint8_t { face, edge, vertex };
  struct Nearest {
    Vec3 foot = Vec3::Zero();
    Feature feature = Feature::face;
    /// Unit, outward: of the face; or the mean of the faces at an edge or a vertex, there by their angles, which tells
    /// inside from outside (Bærentzen and Aanæs 2005).
    Vec3 normal = Vec3::UnitZ();
    Vec3 edge = Vec3::Zero();  ///< unit, along it; of an edge only
  };
  /// On the borders between what is nearest to a face and what is nearest to its edges it is the face.
  [[nodiscard]] Nearest nearest(const Vec3& x) const;

  bool operator==(const TriangleMesh& other) const { return triangles_ == other.triangles_; }

 private:
  struct Tree;
  Triangles triangles_;
  std::shared_ptr<const Tree> tree_;
};

}  // namespace trame::micro
