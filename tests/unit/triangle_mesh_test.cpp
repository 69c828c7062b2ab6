/// \file
/// Surfaces of triangles: the nearest point against boxes and brute force, what is no surface, files, scenes.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <random>

#include "micro/rigid/surface.h"
#include "micro/scene/scene.h"
#include "tests/support/meshes.h"
#include "tests/support/messages.h"
#include "tests/support/rod_scene.h"
#include "tests/support/temporary_folder.h"

namespace trame::micro {
namespace {

using test::mesh_of;
using trame::test::expect_mentions;
using trame::test::input_error;

class RandomPoints {
 public:
  Vec3 within(const Vec3& half) {
    return half.cwiseProduct(Vec3(uniform_(random_), uniform_(random_), uniform_(random_)));
  }

 private:
  std::mt19937 random_{7};
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

Surface surface_of(const test::Corners& corners) { return {.shape = SurfaceShape::mesh, .mesh = mesh_of(corners)}; }

void expect_equal(const SurfaceView& seen, const SurfaceView& expected, const Vec3& x) {
  EXPECT_NEAR(seen.distance, expected.distance, 1e-12) << x.transpose();
  EXPECT_LT((seen.normal - expected.normal).norm(), 1e-9) << x.transpose();
  EXPECT_LT((seen.hessian() - expected.hessian()).norm(), 1e-6) << x.transpose();
}

// Faces, edges and corners of a box, whose diagonals are no edges; on the borders between them, too.
TEST(TriangleMesh, OfABoxIsThatBox) {
  const Vec3 half(1, 2, 3), center(0.5, -0.25, 2);
  const Surface mesh = surface_of(test::box_corners(center - half, center + half));
  const Surface box{.shape = SurfaceShape::box, .center = center, .half_size = half};
  RandomPoints random;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 x = center + random.within({2, 4, 6});
    const Vec3 depth = half - (x - center).cwiseAbs();
    if (depth.minCoeff() > 0) {  // within, where the nearest face may be one of two
      Vec3 sorted = depth;
      std::sort(sorted.data(), sorted.data() + 3);
      if (sorted[1] - sorted[0] < 1e-9) continue;
    }
    expect_equal(view(mesh, x), view(box, x), x);
  }
  for (const Vec3& x : {Vec3(0, 0, 4), Vec3(1, 0, 4), Vec3(1, 2, 4), Vec3(1, 2, 3.5), Vec3(1.5, 0, 0), Vec3(1, 3, 0),
                        Vec3(0, 2.5, 3), Vec3(0.25, 0.5, 3.1)})
    expect_equal(view(mesh, center + x), view(box, center + x), x);
}

// On an edge or a corner that sticks out by no angle, as between the halves of a face.
TEST(TriangleMesh, CoplanarTrianglesHaveNoEdgeBetweenThem) {
  const Surface mesh = surface_of(test::box_corners({-1, -1, -1}, {1, 1, 1}));
  for (int i = -9; i <= 9; ++i) {
    const SurfaceView seen = view(mesh, {0.1 * i, 0.1 * i, 1.5});  // above the diagonal of the upper face
    EXPECT_NEAR(seen.distance, 0.5, 1e-14);
    EXPECT_EQ(seen.curvature, 0) << i;
  }
}

// An angle in two arms, of which the inner edge is concave: the nearer of two boxes from outside.
TEST(TriangleMesh, OfAnAngleIsTheUnionOfTwoBoxes) {
  const Vec3 corner[] = {{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
  test::Corners corners;
  for (int i = 0; i < 6; ++i) {
    const Vec3 a = corner[i], b = corner[(i + 1) % 6], up = Vec3::UnitZ();
    corners.push_back({a, b, b + up});
    corners.push_back({a, b + up, a + up});
  }
  for (const auto& [a, b, c] : {std::array{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    corners.push_back({corner[a], corner[c], corner[b]});
    corners.push_back({corner[a] + Vec3::UnitZ(), corner[b] + Vec3::UnitZ(), corner[c] + Vec3::UnitZ()});
  }
  const Surface angle = surface_of(corners);
  const Surface arms[] = {{.shape = SurfaceShape::box, .center = {1.5, 0.5, 0.5}, .half_size = {1.5, 0.5, 0.5}},
                          {.shape = SurfaceShape::box, .center = {0.5, 1.5, 0.5}, .half_size = {0.5, 1.5, 0.5}}};
  RandomPoints random;
  int n_within = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 x = Vec3(1.5, 1.5, 0.5) + random.within({2, 2, 1});
    const double nearer = std::min(view(arms[0], x).distance, view(arms[1], x).distance);
    const double distance = view(angle, x).distance;
    EXPECT_EQ(distance > 0, nearer > 0) << x.transpose();
    if (nearer > 0) EXPECT_NEAR(distance, nearer, 1e-12) << x.transpose();
    n_within += nearer < 0 ? 1 : 0;
  }
  EXPECT_GT(n_within, 1000);
}

TEST(TriangleMesh, DistanceHasTheDerivativesThatItTells) {
  const Surface ball = surface_of(test::sphere_corners(1, 2));
  RandomPoints random;
  constexpr double h = 1e-6;
  int n_curved = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 x = random.within({1.6, 1.6, 1.6});
    if (x.norm() < 1.05) continue;
    const SurfaceView seen = view(ball, x);
    EXPECT_NEAR(seen.distance, x.norm() - 1, 0.06);
    for (int d = 0; d < 3; ++d) {
      const SurfaceView more = view(ball, x + h * Vec3::Unit(d)), less = view(ball, x - h * Vec3::Unit(d));
      EXPECT_NEAR((more.distance - less.distance) / (2 * h), seen.normal[d], 1e-6) << x.transpose();
      if (more.curvature == 0 || less.curvature == 0 || seen.curvature == 0) continue;
      ++n_curved;
      const Vec3 change = (more.normal - less.normal) / (2 * h);
      if (std::abs(more.curvature - less.curvature) < 1e-4)  // not across a border
        EXPECT_LT((change - seen.hessian().col(d)).norm(), 0.02) << x.transpose();
    }
  }
  EXPECT_GT(n_curved, 500);
}

std::string error_of(const test::Corners& corners) {
  try {
    (void)mesh_of(corners);
  } catch (const MeshError& error) {
    return error.what();
  }
  return "";
}

TEST(TriangleMesh, WhatIsNoClosedSurfaceIsRefused) {
  const test::Corners box = test::box_corners({-1, -1, -1}, {1, 1, 1});
  EXPECT_EQ(error_of(box), "");
  test::Corners turned = box;  // one triangle the other way round, and all of them
  std::swap(turned[3][0], turned[3][1]);
  EXPECT_EQ(error_of(turned), "");
  for (auto& t : turned = box) std::swap(t[0], t[1]);
  EXPECT_GT(view(surface_of(turned), {0, 0, 3}).distance, 0);
  EXPECT_LT(view(surface_of(turned), {0, 0, 0.9}).distance, 0);
  test::Corners open = box;
  open.pop_back();
  EXPECT_NE(error_of(open).find("not closed: 3 edges"), std::string::npos);
  test::Corners flat = box;
  flat.push_back({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}});
  EXPECT_NE(error_of(flat), "");
  test::Corners two = box;
  for (const auto& t : test::box_corners({0, 0, 0}, {2, 2, 2})) two.push_back(t);
  EXPECT_NE(error_of(two).find("cuts itself"), std::string::npos);
  EXPECT_NE(error_of({{{0, 0, 0}, {1, 0, 0}}}).find("3 corners"), std::string::npos);
}

/// Files of a box, in all formats, and what is wrong in them.
class TriangleFiles : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  static std::string text_stl(const test::Corners& corners) {
    std::string text = "solid box\n";
    for (const auto& t : corners) {
      text += "facet normal 0 0 0\n outer loop\n";
      for (const Vec3& p : t) text += fmt::format("  vertex {} {} {}\n", p.x(), p.y(), p.z());
      text += " endloop\nendfacet\n";
    }
    return text + "endsolid box\n";
  }
  static std::string binary_stl(const test::Corners& corners, std::uint32_t n) {
    static_assert(std::endian::native == std::endian::little);
    std::string bytes(80, ' ');
    bytes.append(reinterpret_cast<const char*>(&n), 4);
    for (const auto& t : corners) {
      float numbers[12] = {};
      for (int i = 0; i < 9; ++i) numbers[3 + i] = static_cast<float>(t[i / 3][i % 3]);
      bytes.append(reinterpret_cast<const char*>(numbers), sizeof numbers);
      bytes.append(2, '\0');
    }
    return bytes;
  }
  static std::string listed(const test::Corners& corners, const char* head, const char* vertex, const char* face,
                            Index first) {
    const Triangles t = joined(corners);
    std::string text = fmt::format(fmt::runtime(head), t.points.size(), t.corners.size());
    for (const Vec3& p : t.points) text += fmt::format("{}{} {} {}\n", vertex, p.x(), p.y(), p.z());
    for (const auto& [a, b, c] : t.corners) text += fmt::format("{}{} {} {}\n", face, a + first, b + first, c + first);
    return text;
  }
  static std::string error_of(const std::filesystem::path& file) {
    try {
      (void)read_triangles(file);
    } catch (const MeshError& error) {
      return error.what();
    }
    return "";
  }

  const trame::test::TemporaryFolder folder_;
  const test::Corners box_ = test::box_corners({-1, -2, -3}, {1, 2, 3});
};

TEST_F(TriangleFiles, AreReadInTheFormatsThatProgramsWrite) {
  const std::filesystem::path files[] = {
      write("text.stl", text_stl(box_)), write("binary.stl", binary_stl(box_, 12)),
      write("box.obj", listed(box_, "# {} {}\n", "v ", "f ", 1)),
      write("box.off", listed(box_, "OFF\n{} {} 0\n", "", "3 ", 0)),
      write("box.ply", listed(box_,
                              "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
                              "property float z\nelement face {}\nproperty list uchar int vertex_indices\n"
                              "end_header\n",
                              "", "3 ", 0))};
  const Surface box{.shape = SurfaceShape::box, .half_size = {1, 2, 3}};
  for (const auto& file : files) {
    const Triangles triangles = read_triangles(file);
    EXPECT_EQ(triangles.points.size(), 8u) << file;
    ASSERT_EQ(triangles.corners.size(), 12u) << file;
    const Surface mesh{.shape = SurfaceShape::mesh, .mesh = std::make_shared<const TriangleMesh>(triangles)};
    for (const Vec3& x : {Vec3(2, 3, 4), Vec3(0, 0, 5), Vec3(0.1, 0.2, 2)})
      EXPECT_NEAR(view(mesh, x).distance, view(box, x).distance, 1e-12) << file;
  }
}

TEST_F(TriangleFiles, WhatCannotBeReadIsRefused) {
  EXPECT_EQ(error_of(folder_ / "none.stl"), "cannot be read");
  EXPECT_EQ(error_of(folder_.path()), "cannot be read");
  const std::filesystem::path pipe = folder_ / "pipe.stl";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(error_of(pipe), "cannot be read");
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{
           {"empty.stl", ""},
           {"words.stl", "solid and nothing else"},
           {"other.txt", "solid box\nendsolid"},
           {"many.stl", binary_stl(box_, 0xFFFFFFFF)},
           {"cut.stl", binary_stl(box_, 12).substr(0, 300)},
           {"quads.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"},
           {"beyond.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 7\n"},
           {"nan.stl",
            "solid\nfacet normal 0 0 0\nouter loop\nvertex nan 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
            "endfacet\nendsolid\n"}})
    EXPECT_NE(error_of(write(name, text)), "") << name;
}

TEST_F(TriangleFiles, ASceneNeedsTheFileNoMoreOnceItIsRead) {
  (void)write("punch.stl", binary_stl(box_, 12));
  const auto scene_with = [](const std::string& keys) {
    return trame::test::rod_scene(R"([[body]]
name = "punch"
position = ["1 mm", "2 mm", "9 mm"]
[[body.surface]]
shape = "mesh"
)" + keys + R"(
[[stage]]
name = "push"
)");
  };
  const Scene scene =
      parse_scene(scene_with("file = \"punch.stl\"  # of a drawing\nunit = \"2 mm\""), "s.toml", folder_.path());
  const Surface& read = scene.bodies.at(0).surfaces.at(0).surface;
  const Surface box{.shape = SurfaceShape::box, .half_size = {2e-3, 4e-3, 6e-3}};
  for (const Vec3& x : {Vec3(3e-3, 5e-3, 7e-3), Vec3(0, 0, 8e-3), Vec3(0, 0, 5e-3)})
    EXPECT_NEAR(view(read, x).distance, view(box, x).distance, 1e-15);
  const Scene again = parse_scene(scene.text, "s.toml", "/");
  EXPECT_EQ(again.bodies, scene.bodies);
  EXPECT_EQ(again.text, scene.text);
  const auto error = [&](const std::string& keys) {
    return input_error([&] { (void)parse_scene(scene_with(keys), "s.toml", folder_.path()); });
  };
  expect_mentions(error("file = \"punch.stl\""), {"surface[1].unit: missing"});
  expect_mentions(error("unit = \"1 mm\""), {"surface[1].file: missing", "or triangles"});
  expect_mentions(error("file = \"other.stl\"\nunit = \"1 mm\""),
                  {"surface[1].file = \"other.stl\"", "cannot be read"});
  expect_mentions(error("file = \"punch.stl\"\nunit = \"1 mm\"\ntriangles = [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]"),
                  {"surface[1].triangles", "must not stand beside a file"});
  expect_mentions(error("unit = \"1 mm\"\ntriangles = [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]"),
                  {"surface[1].triangles", "not closed"});
  expect_mentions(error("unit = \"1 mm\"\ntriangles = [[[0, 0, 0], [1e7, 0, 0], [0, 1, 0]]]"), {"beyond 1e+06"});
  expect_mentions(error("file = \"punch.stl\"\nunit = \"1 mm\"\nradius = \"1 mm\""),
                  {"surface[1].radius", "is none of a mesh"});
  (void)write("open.stl", binary_stl(test::Corners(box_.begin(), box_.begin() + 11), 11));
  expect_mentions(error("file = \"open.stl\"\nunit = \"1 mm\""), {"file = \"open.stl\"", "not closed: 3 edges"});
}

}  // namespace
}  // namespace trame::micro
