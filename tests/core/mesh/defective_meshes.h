// Solids with known volumes, and ways to spoil them: what repair is tested on.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "base/units.h"
#include "grid_mesh.h"
#include "mesh/tri_mesh.h"

namespace s3::test {

inline TriMesh without_unused(const TriMesh& mesh) {
  std::vector<Index> number(static_cast<std::size_t>(mesh.vertices.rows()), -1);
  TriMesh out;
  out.triangles.resize(mesh.triangles.rows(), 3);
  Index used = 0;
  for (Eigen::Index i = 0; i < mesh.triangles.size(); ++i) {
    Index& n = number[static_cast<std::size_t>(mesh.triangles.data()[i])];
    if (n < 0) n = used++;
    out.triangles.data()[i] = n;
  }
  out.vertices.resize(used, 3);
  for (std::size_t v = 0; v < number.size(); ++v)
    if (number[v] >= 0) out.vertices.row(number[v]) = mesh.vertices.row(static_cast<Index>(v));
  return out;
}

/// A box with n×n squares on every face.
inline TriMesh box_surface(const Vec3& size, const Vec3& at = Vec3::Zero(), int n = 3) {
  TriMesh mesh = without_unused(boundary_surface(make_grid(n, n, n, size)));
  mesh.vertices.rowwise() += at.transpose();
  return mesh;
}

/// A sphere-like surface: a box's surface blown up to the radius.
inline TriMesh ball_surface(double radius, const Vec3& at = Vec3::Zero(), int n = 8) {
  TriMesh mesh = box_surface(Vec3::Constant(2), Vec3::Constant(-1), n);
  for (Index v = 0; v < mesh.vertices.rows(); ++v)
    mesh.vertices.row(v) =
        at.transpose() + radius * mesh.vertices.row(v) / mesh.vertices.row(v).norm();
  return mesh;
}

inline TriMesh joined(const TriMesh& a, const TriMesh& b) {
  TriMesh both;
  both.vertices.resize(a.vertices.rows() + b.vertices.rows(), 3);
  both.vertices << a.vertices, b.vertices;
  both.triangles.resize(a.triangles.rows() + b.triangles.rows(), 3);
  both.triangles << a.triangles,
      (b.triangles.array() + static_cast<Index>(a.vertices.rows())).matrix();
  return both;
}

inline TriMesh inside_out(TriMesh mesh) {
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

inline Vec3 middle_of(const TriMesh& mesh, Index f) {
  return (mesh.vertices.row(mesh.triangles(f, 0)) + mesh.vertices.row(mesh.triangles(f, 1)) +
          mesh.vertices.row(mesh.triangles(f, 2)))
             .transpose() /
         3;
}

/// Removes the triangles whose middle the test names.
inline TriMesh without(const TriMesh& mesh, const std::function<bool(const Vec3&)>& goes) {
  TriMesh out = mesh;
  Eigen::Index kept = 0;
  for (Index f = 0; f < mesh.triangles.rows(); ++f)
    if (!goes(middle_of(mesh, f))) out.triangles.row(kept++) = mesh.triangles.row(f);
  out.triangles.conservativeResize(kept, 3);
  return out;
}

inline TriMesh without_every(const TriMesh& mesh, int step) {
  int i = 0;
  return without(mesh, [&](const Vec3&) { return ++i % step == 0; });
}

inline TriMesh with_flipped_every(TriMesh mesh, int step) {
  for (Index f = 0; f < mesh.triangles.rows(); f += step)
    std::swap(mesh.triangles(f, 0), mesh.triangles(f, 1));
  return mesh;
}

/// Every triangle gets corners of its own, moved by up to `noise`.
inline TriMesh as_soup(const TriMesh& mesh, double noise = 0) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> step(-noise, noise);
  TriMesh soup;
  soup.vertices.resize(3 * mesh.triangles.rows(), 3);
  soup.triangles.resize(mesh.triangles.rows(), 3);
  for (Index f = 0; f < mesh.triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i) {
      soup.vertices.row(3 * f + i) = mesh.vertices.row(mesh.triangles(f, i));
      if (noise > 0)
        for (int k = 0; k < 3; ++k) soup.vertices(3 * f + i, k) += step(random);
      soup.triangles(f, i) = 3 * f + i;
    }
  return soup;
}

inline TriMesh with_triangles(TriMesh mesh, const std::vector<std::array<Index, 3>>& more) {
  const Eigen::Index old = mesh.triangles.rows();
  mesh.triangles.conservativeResize(old + static_cast<Eigen::Index>(more.size()), 3);
  for (std::size_t i = 0; i < more.size(); ++i)
    mesh.triangles.row(old + static_cast<Eigen::Index>(i)) << more[i][0], more[i][1], more[i][2];
  return mesh;
}

inline TriMesh with_vertices(TriMesh mesh, const std::vector<Vec3>& more) {
  const Eigen::Index old = mesh.vertices.rows();
  mesh.vertices.conservativeResize(old + static_cast<Eigen::Index>(more.size()), 3);
  for (std::size_t i = 0; i < more.size(); ++i)
    mesh.vertices.row(old + static_cast<Eigen::Index>(i)) = more[i];
  return mesh;
}

/// Doubles every `step`th triangle; turned or not.
inline TriMesh with_doubled_every(const TriMesh& mesh, int step, bool turned) {
  std::vector<std::array<Index, 3>> more;
  for (Index f = 0; f < mesh.triangles.rows(); f += step)
    more.push_back({mesh.triangles(f, 0), mesh.triangles(f, turned ? 2 : 1),
                    mesh.triangles(f, turned ? 1 : 2)});
  return with_triangles(mesh, more);
}

/// A triangle loses its neighbour's vertex: the edge keeps the midpoint on one side only.
inline TriMesh with_t_junctions(const TriMesh& mesh, int step, double off = 0) {
  TriMesh out = mesh;
  const auto count = static_cast<Index>(mesh.triangles.rows());
  for (Index f = 0; f < count; f += step) {
    const Index a = out.triangles(f, 0), b = out.triangles(f, 1), c = out.triangles(f, 2);
    const Vec3 middle =
        0.5 * (out.vertices.row(a) + out.vertices.row(b)).transpose() + Vec3(off, -off, off);
    out = with_vertices(out, {middle});
    const auto m = static_cast<Index>(out.vertices.rows() - 1);
    out.triangles.row(f) << a, m, c;
    out = with_triangles(out, {{m, b, c}});
  }
  return out;
}

/// Two triangles of an edge split in four, with the new vertex exactly on it: two have no area when
/// `flat`.
inline TriMesh with_flat_triangles(const TriMesh& mesh, int step) {
  TriMesh out = mesh;
  const auto count = static_cast<Index>(mesh.triangles.rows());
  for (Index f = 0; f < count; f += step) {
    // A flat triangle between the edge and itself: a→m→b with m on the edge, and the face a m c b.
    const Index a = out.triangles(f, 0), b = out.triangles(f, 1), c = out.triangles(f, 2);
    const Vec3 middle = 0.5 * (out.vertices.row(a) + out.vertices.row(b)).transpose();
    out = with_vertices(out, {middle});
    const auto m = static_cast<Index>(out.vertices.rows() - 1);
    out.triangles.row(f) << a, m, c;
    out = with_triangles(out, {{m, b, c}, {a, b, m}});
  }
  return out;
}

/// Some vertices become two, a little apart, joined by slivers.
inline TriMesh with_near_duplicates(const TriMesh& mesh, int step, double apart) {
  TriMesh out = mesh;
  for (Index f = 0; f < mesh.triangles.rows(); f += step) {
    const Index a = out.triangles(f, 0), b = out.triangles(f, 1);
    // Splits edge a–b's triangle pair next to a.
    Index g = -1, corner = 0;
    for (Index h = 0; h < out.triangles.rows() && g < 0; ++h)
      for (int i = 0; i < 3; ++i)
        if (out.triangles(h, i) == b && out.triangles(h, (i + 1) % 3) == a) g = h, corner = i;
    if (g < 0) continue;
    const Vec3 p = out.vertices.row(a),
               q = p + apart * (out.vertices.row(b).transpose() - p).normalized();
    out = with_vertices(out, {q});
    const auto m = static_cast<Index>(out.vertices.rows() - 1);
    const Index c = out.triangles(f, 2), d = out.triangles(g, (corner + 2) % 3);
    out.triangles.row(f) << a, m, c;
    out.triangles.row(g) << b, m, d;
    out = with_triangles(out, {{m, b, c}, {m, a, d}});
  }
  return out;
}

/// Joins vertices of equal coordinates.
inline TriMesh welded(TriMesh mesh) {
  for (Index i = 0; i < mesh.vertices.rows(); ++i)
    for (Index j = 0; j < i; ++j)
      if (mesh.vertices.row(i) == mesh.vertices.row(j)) {
        mesh.triangles = mesh.triangles.unaryExpr([&](Index v) { return v == i ? j : v; }).eval();
        break;
      }
  return mesh;
}

enum class Outcome { valid, rebuild, error };

struct DefectiveMesh {
  std::string name;
  TriMesh mesh;
  Outcome outcome;
  double volume = 0;      // mm³ after repair, for valid ones
  std::string code = {};  // of the change or error that must appear
};

inline std::vector<DefectiveMesh> defective_meshes() {
  const TriMesh box = box_surface(Vec3(10, 8, 6)), cube = box_surface(Vec3::Constant(10));
  const TriMesh ball = ball_surface(10);
  const double ball_volume = enclosed_volume(ball);
  const auto on_top = [](const Vec3& p) { return p.z() > 6 - 1e-9; };
  const auto cap = [](double cosine) {
    return [cosine](const Vec3& p) { return p.normalized().dot(Vec3(0.6, 0, 0.8)) > cosine; };
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<DefectiveMesh> all;
  const auto add = [&](const std::string& name, const TriMesh& mesh, Outcome outcome,
                       double volume = 0, const std::string& code = "") {
    all.push_back({name, mesh, outcome, volume, code});
  };
  const auto valid = Outcome::valid, rebuild = Outcome::rebuild, error = Outcome::error;

  add("a sound box", box, valid, 480);
  add("one triangle missing", without_every(box, 100), valid, 480, "repair.holes_flat");
  add("every tenth triangle missing", without_every(ball, 10), valid, ball_volume,
      "repair.holes_flat");
  add("no lid", without(box, on_top), valid, 480, "repair.holes_flat");
  add("a flat hole in the lid",
      without(box,
              [&](const Vec3& p) {
                return on_top(p) && std::abs(p.x() - 5) < 1.7 && std::abs(p.y() - 4) < 1.4;
              }),
      valid, 480, "repair.holes_flat");
  add("a curved hole", without(ball, cap(0.9)), valid, ball_volume, "repair.holes_curved");
  add("a large curved hole", without(ball, cap(0.75)), valid, 0, "repair.holes_curved");
  add("two curved holes",
      without(without(ball, cap(0.92)),
              [&](const Vec3& p) { return p.normalized().dot(Vec3(-1, 0, 0)) > 0.93; }),
      valid, ball_volume, "repair.holes_curved");
  {
    const TriMesh tube = without(
        joined(box_surface(Vec3(10, 10, 6)), inside_out(box_surface(Vec3(4, 4, 6), Vec3(3, 3, 0)))),
        [](const Vec3& p) { return p.z() < 1e-9 || p.z() > 6 - 1e-9; });
    add("a tube without ends", tube, valid, 504, "repair.holes_flat");
  }
  add("some triangles flipped", with_flipped_every(ball, 7), valid, ball_volume, "repair.turn");
  add("half of the triangles flipped", with_flipped_every(box, 2), valid, 480, "repair.turn");
  add("everything inside out", inside_out(box), valid, 480, "repair.turn_shells");
  add("some triangles doubled", with_doubled_every(box, 5, false), valid, 480, "repair.duplicates");
  add("some triangles doubled and turned", with_doubled_every(box, 7, true), valid, 480,
      "repair.duplicates");
  add("both sides of everything", with_doubled_every(box, 1, true), valid, 480,
      "repair.duplicates");
  add("vertices not joined", as_soup(ball), valid, ball_volume, "repair.weld");
  add("vertices not quite joined", as_soup(ball, 1e-5), valid, ball_volume, "repair.stitch");
  add("vertices apart like single precision", as_soup(box, 4e-7), valid, 480, "repair.stitch");
  add("vertices next to vertices", with_near_duplicates(box, 11, 1e-6), valid, 480,
      "repair.short_edges");
  add("T-junctions", with_t_junctions(box, 9), valid, 480, "repair.split_edges");
  add("T-junctions a little off", with_t_junctions(box, 9, 1e-5), valid, 480, "repair.split_edges");
  add("triangles without area", with_flat_triangles(box, 6), valid, 480, "repair.flat_triangles");
  add("triangles with a repeated corner", with_triangles(box, {{0, 0, 1}, {3, 4, 3}}), valid, 480);
  add("unused vertices", with_vertices(box, {Vec3(1, 1, 1), Vec3(99, 0, 0)}), valid, 480,
      "repair.unused_vertices");
  add("bodies that share an edge",
      welded(joined(cube, box_surface(Vec3::Constant(10), Vec3(10, 10, 0)))), valid, 2000,
      "repair.split");
  add("bodies that share a vertex",
      welded(joined(cube, box_surface(Vec3::Constant(10), Vec3(10, 10, 10)))), valid, 2000,
      "repair.split");
  add("bodies that share a face",
      welded(joined(cube, box_surface(Vec3::Constant(10), Vec3(10, 0, 0)))), valid, 2000,
      "repair.duplicates");
  add("bodies face to face, not joined",
      joined(cube, box_surface(Vec3::Constant(10), Vec3(10, 0, 0))), valid, 2000,
      "repair.duplicates");
  {
    TriMesh wall = joined(cube, box_surface(Vec3::Constant(10), Vec3(10, 0, 0)));
    bool first = false;
    const auto at_wall = [](const Vec3& p) { return std::abs(p.x() - 10) < 1e-9; };
    Index n = 0;
    wall = without(wall, [&](const Vec3& p) {
      first = n++ < cube.triangles.rows();
      return at_wall(p) && !first;
    });
    add("a wall inside", welded(wall), valid, 2000, "repair.inner_walls");
  }
  {  // A sheet of one triangle layer that sticks out of an edge.
    TriMesh flap = with_vertices(cube, {Vec3(14, 0, 13), Vec3(14, 3, 13)});
    Index a = -1, b = -1;
    for (Index v = 0; v < cube.vertices.rows(); ++v) {
      if ((cube.vertices.row(v).transpose() - Vec3(10, 0, 10)).norm() < 1e-9) a = v;
      if ((cube.vertices.row(v).transpose() - Vec3(10, 10.0 / 3, 10)).norm() < 1e-9) b = v;
    }
    const auto n = static_cast<Index>(cube.vertices.rows());
    add("a flap of one layer", with_triangles(flap, {{a, b, n}, {b, n + 1, n}}), valid, 1000,
        "repair.inner_walls");
    add("a flap of two layers",
        with_triangles(flap, {{a, b, n}, {b, n + 1, n}, {b, a, n}, {n + 1, b, n}}), valid, 1000,
        "repair.duplicates");
  }
  add("a cavity", joined(cube, inside_out(ball_surface(3, Vec3::Constant(5), 4))), valid,
      1000 - enclosed_volume(ball_surface(3, Vec3::Zero(), 4)));
  add("a cavity that faces outward", joined(cube, ball_surface(3, Vec3::Constant(5), 4)), valid,
      1000 - enclosed_volume(ball_surface(3, Vec3::Zero(), 4)), "repair.cavities");
  add("a body inside out beside another",
      joined(cube, inside_out(box_surface(Vec3::Constant(5), Vec3(20, 0, 0)))), valid, 1125,
      "repair.turn_shells");
  add("bodies that overlap", joined(cube, box_surface(Vec3::Constant(10), Vec3(5, 4, 3))), rebuild);
  add("bodies that overlap, one inside out",
      joined(cube, inside_out(box_surface(Vec3::Constant(10), Vec3(5, 4, 3)))), rebuild, 0,
      "repair.turn_shells");
  {
    TriMesh crossed = box_surface(Vec3(10, 10, 10));
    for (Index v = 0; v < crossed.vertices.rows(); ++v)  // the lid turned by 180°: an hourglass
      if (crossed.vertices(v, 2) > 9.9)
        crossed.vertices.row(v).head<2>() =
            Vec3(10, 10, 0).head<2>().transpose() - crossed.vertices.row(v).head<2>();
    add("a surface through itself", crossed, rebuild);
  }
  {
    TriMesh swapped = ball_surface(10, Vec3::Zero(), 16);
    const Index f = 77, a = swapped.triangles(f, 0), b = swapped.triangles(f, 1);
    swapped.vertices.row(a).swap(swapped.vertices.row(b));
    add("two vertices that changed places", swapped, valid,
        enclosed_volume(ball_surface(10, Vec3::Zero(), 16)), "repair.crossings");
  }
  add("a loose sheet of no volume",
      joined(cube, with_triangles(without(box_surface(Vec3(3, 3, 3), Vec3(20, 0, 0)),
                                          [](const Vec3& p) { return p.z() > 1e-9; }),
                                  {})),
      valid, 1000, "repair.flat_shells");
  add("a speck", joined(cube, box_surface(Vec3::Constant(0.003), Vec3(12, 3, 3), 1)), valid, 1000,
      "repair.specks");
  {
    TriMesh wild = without_every(box, 1000);
    wild = with_vertices(wild, {Vec3(nan, 0, 0), Vec3(1e30, 1, 1)});
    const auto n = static_cast<Index>(wild.vertices.rows());
    add("corners that are no numbers", with_triangles(wild, {{0, 1, n - 2}, {2, 3, n - 1}}), valid,
        480, "repair.wild_coordinates");
  }
  add("flipped, unjoined, with holes", without_every(with_flipped_every(as_soup(ball), 9), 23),
      valid, ball_volume, "repair.weld");
  add("doubled, flipped, inside out",
      inside_out(with_flipped_every(with_doubled_every(box, 4, false), 10)), valid, 480,
      "repair.duplicates");
  add("T-junctions, holes, flat triangles",
      without_every(with_flat_triangles(with_t_junctions(box, 13), 17), 41), valid, 480,
      "repair.split_edges");
  add("unjoined with noise, no lid", without(as_soup(box, 1e-6), on_top), valid, 480,
      "repair.stitch");
  add("overlap, holes, flips",
      without_every(
          with_flipped_every(joined(cube, box_surface(Vec3::Constant(10), Vec3(5, 4, 3))), 8), 19),
      rebuild, 0, "repair.turn");
  add("a flat sheet", without(box, [&](const Vec3& p) { return !on_top(p); }), error, 0,
      "mesh.open_surface");
  add("a sheet of two layers",
      with_doubled_every(without(box, [&](const Vec3& p) { return !on_top(p); }), 1, true), error,
      0, "mesh.open_surface");
  add("one triangle", with_triangles({cube.vertices, Triangles(0, 3)}, {{0, 1, 2}}), error, 0,
      "mesh.open_surface");
  add("nothing", {}, error, 0, "mesh.empty");
  return all;
}

}  // namespace s3::test
