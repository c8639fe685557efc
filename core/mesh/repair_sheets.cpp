#include "mesh/repair_sheets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mesh/surface_edges.h"
#include "mesh/winding_number.h"

namespace s3 {

namespace {

constexpr int kMaxSheetRounds = 100;
constexpr std::size_t kForgottenSheets = 16;  // at most in a round: each one costs at every sample
constexpr int kSamples = 5;                   // of a part, on its largest triangles
constexpr double kSampleOffset = 1e-5;        // of the diagonal
constexpr double kNearInteger = 0.2;          // of a winding number

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

// A triangle by its sorted corners, and whether sorting them was an even permutation.
struct Sorted {
  std::array<Index, 3> corners;
  Index triangle;
  bool even;
  bool operator<(const Sorted& o) const {
    return corners != o.corners ? corners < o.corners : triangle < o.triangle;
  }
};

Sorted sorted_corners(const TriMesh& mesh, Index f) {
  Sorted s{{mesh.triangles(f, 0), mesh.triangles(f, 1), mesh.triangles(f, 2)}, f, true};
  const auto order = [&](std::size_t i, std::size_t j) {
    if (s.corners[i] > s.corners[j]) std::swap(s.corners[i], s.corners[j]), s.even = !s.even;
  };
  order(0, 1), order(1, 2), order(0, 1);
  return s;
}

// Parts of double triangles (opposite layers) that bound nothing: without them, more of the edges
// around the part have an even number of triangles.
void drop_flaps(const TriMesh& mesh, const std::vector<char>& is_double, std::vector<char>& keep) {
  const std::vector<Side> sides = sorted_sides(mesh);
  const auto n = at(static_cast<Index>(mesh.triangles.rows()));
  DisjointSets sets(n);
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    if (end - begin == 2 && is_double[at(sides[begin].triangle())] &&
        is_double[at(sides[begin + 1].triangle())])
      sets.join(sides[begin].triangle(), sides[begin + 1].triangle());
  });
  std::vector<Index> votes(n, 0);  // of a part's leader: for removing it
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    const std::size_t count = end - begin;
    if (count == 1) return;
    for (std::size_t i = begin; i < end; ++i) {
      if (!is_double[at(sides[i].triangle())]) continue;
      const Index part = sets.find(sides[i].triangle());
      std::size_t of_part = 0;
      for (std::size_t j = begin; j < end; ++j)
        of_part += is_double[at(sides[j].triangle())] && sets.find(sides[j].triangle()) == part;
      if (of_part % 2 == 1) votes[at(part)] += count % 2 == 1 ? 1 : -1;
    }
  });
  for (std::size_t f = 0; f < n; ++f)
    if (is_double[f] && votes[at(sets.find(static_cast<Index>(f)))] > 0) keep[f] = 0;
}

}  // namespace

Defect remove_duplicate_triangles(TriMesh& mesh) {
  Defect removed;
  std::vector<Sorted> all;
  all.reserve(static_cast<std::size_t>(mesh.triangles.rows()));
  for (Index f = 0; f < mesh.triangles.rows(); ++f) all.push_back(sorted_corners(mesh, f));
  std::sort(all.begin(), all.end());
  std::vector<char> keep(all.size(), 1), is_double(all.size(), 0);
  for (std::size_t begin = 0, end; begin < all.size(); begin = end) {
    int net = 0;
    for (end = begin; end < all.size() && all[end].corners == all[begin].corners; ++end)
      net += all[end].even ? 1 : -1;
    if (end - begin == 1) continue;
    bool kept = false;
    for (std::size_t i = begin; i < end; ++i) {
      const bool wanted = !kept && (net == 0 || all[i].even == (net > 0));
      keep[at(all[i].triangle)] = wanted;
      if (wanted && net == 0) is_double[at(all[i].triangle)] = 1;
      if (!wanted) removed.add(centroid_of(mesh, all[i].triangle));
      kept = kept || wanted;
    }
  }
  if (removed.count == 0) return removed;
  std::vector<char> doubles;
  for (std::size_t f = 0; f < keep.size(); ++f)
    if (keep[f]) doubles.push_back(is_double[f]);
  keep_triangles(mesh, keep);
  keep.assign(doubles.size(), 1);
  drop_flaps(mesh, doubles, keep);
  for (std::size_t f = 0; f < keep.size(); ++f)
    if (!keep[f]) removed.add(centroid_of(mesh, static_cast<Index>(f)));
  keep_triangles(mesh, keep);
  return removed;
}

Defect turn_to_neighbours(TriMesh& mesh) {
  const auto n = at(static_cast<Index>(mesh.triangles.rows()));
  // Neighbours across edges with two triangles: 3·f + i → the other side's corner and whether they
  // agree.
  std::vector<Index> other(3 * n, -1);
  std::vector<char> agrees(3 * n, 1);
  const std::vector<Side> sides = sorted_sides(mesh);
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    if (end - begin != 2) return;
    const Side &a = sides[begin], &b = sides[begin + 1];
    other[at(a.corner)] = b.corner;
    other[at(b.corner)] = a.corner;
    agrees[at(a.corner)] = agrees[at(b.corner)] = a.forward != b.forward;
  });
  std::vector<char> seen(n, 0), turned(n, 0);
  std::vector<Index> part;
  Defect changed;
  for (std::size_t start = 0; start < n; ++start) {
    if (seen[start]) continue;
    part.assign(1, static_cast<Index>(start));
    seen[start] = 1;
    double area = 0, turned_area = 0;
    for (std::size_t head = 0; head < part.size(); ++head) {
      const Index f = part[head];
      const double a = triangle_normal_2a(mesh.vertices, mesh.triangles.row(f)).norm();
      area += a;
      if (turned[at(f)]) turned_area += a;
      for (Index c = 3 * f; c < 3 * f + 3; ++c) {
        if (other[at(c)] < 0) continue;
        const Index g = other[at(c)] / 3;
        if (seen[at(g)]) continue;
        seen[at(g)] = 1;
        turned[at(g)] = agrees[at(c)] ? turned[at(f)] : !turned[at(f)];
        part.push_back(g);
      }
    }
    const bool less = 2 * turned_area <= area;
    for (const Index f : part) {
      if (static_cast<bool>(turned[at(f)]) != less) continue;
      std::swap(mesh.triangles(f, 1), mesh.triangles(f, 2));
      changed.add(centroid_of(mesh, f));
    }
  }
  return changed;
}

namespace {

// A part between edges of more than two triangles.
struct Sheet {
  std::vector<Index> triangles;
  double area = 0;
};

TriMesh only(const TriMesh& mesh, const std::vector<Index>& triangles) {
  std::vector<Index> used;
  for (const Index f : triangles)
    for (int i = 0; i < 3; ++i) used.push_back(mesh.triangles(f, i));
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  TriMesh part;
  part.vertices.resize(static_cast<Eigen::Index>(used.size()), 3);
  for (std::size_t v = 0; v < used.size(); ++v)
    part.vertices.row(static_cast<Eigen::Index>(v)) = mesh.vertices.row(used[v]);
  part.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t f = 0; f < triangles.size(); ++f)
    for (int i = 0; i < 3; ++i)
      part.triangles(static_cast<Eigen::Index>(f), i) = static_cast<Index>(
          std::lower_bound(used.begin(), used.end(), mesh.triangles(triangles[f], i)) -
          used.begin());
  return part;
}

double area_of(const TriMesh& mesh, Index f) {
  return 0.5 * triangle_normal_2a(mesh.vertices, mesh.triangles.row(f)).norm();
}

// Sheets at edges with more than two triangles, the smallest first.
std::vector<Sheet> sheets_of(const TriMesh& mesh, const std::vector<Side>& sides) {
  Index count = 0;
  const std::vector<Index> part = connected_parts(mesh, sides, true, count);
  std::vector<char> at_bad_edge(at(count), 0);
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    if (end - begin > 2)
      for (std::size_t i = begin; i < end; ++i) at_bad_edge[at(part[at(sides[i].triangle())])] = 1;
  });
  std::vector<Sheet> all(at(count));
  for (Index f = 0; f < mesh.triangles.rows(); ++f) {
    Sheet& sheet = all[at(part[at(f)])];
    if (!at_bad_edge[at(part[at(f)])]) continue;
    sheet.triangles.push_back(f);
    sheet.area += area_of(mesh, f);
  }
  std::vector<Sheet> bad;
  for (Sheet& sheet : all)
    if (!sheet.triangles.empty()) bad.push_back(std::move(sheet));
  std::stable_sort(bad.begin(), bad.end(),
                   [](const Sheet& a, const Sheet& b) { return a.area < b.area; });
  return bad;
}

// Every edge has as many triangles one way as the other, so that winding numbers are integers.
bool is_balanced(const std::vector<Side>& sides) {
  bool balanced = true;
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    int net = 0;
    for (std::size_t i = begin; i < end; ++i) net += sides[i].forward ? 1 : -1;
    balanced = balanced && net == 0;
  });
  return balanced;
}

class SheetJudge {
 public:
  SheetJudge(const TriMesh& mesh, bool balanced)
      : mesh_(mesh),
        winding_(mesh),
        offset_(kSampleOffset * bounding_box(mesh.vertices).diagonal()),
        area_(surface_area(mesh)),
        balanced_(balanced) {}

  /// True when the solid is the same without the sheet.
  bool bounds_nothing(const Sheet& sheet) const {
    // Most of an open surface is no wall, whatever the numbers.
    if (!balanced_ && sheet.area > 0.5 * area_) return false;
    const WindingNumber own(only(mesh_, sheet.triangles));
    bool none = true;
    for (const auto& [before, behind] : samples(sheet)) {
      double w_before = winding_.at(before), w_behind = winding_.at(behind);
      for (const WindingNumber& gone : removed_) {
        w_before -= gone.at(before);
        w_behind -= gone.at(behind);
      }
      if (balanced_) {
        none = none && (std::min(w_before, w_behind) > 0.5 || std::max(w_before, w_behind) < 0.5);
      } else {
        // A wall or flap has k and k + 1 of a half on its sides, a border 0 and 1.
        const double mean = 0.5 * (w_before + w_behind),
                     rest = mean - 0.5 * (own.at(before) + own.at(behind));
        none = none && std::abs(mean - std::round(mean)) < kNearInteger &&
               std::abs(rest - std::round(rest)) < kNearInteger;
      }
    }
    return none;
  }

  /// Later judgements are made without these triangles; not in a balanced surface, where all are
  /// judged against the whole.
  void forget(const Sheet& sheet) {
    if (!balanced_) removed_.emplace_back(only(mesh_, sheet.triangles));
  }

  std::size_t forgotten() const { return removed_.size(); }

 private:
  std::vector<std::array<Vec3, 2>> samples(const Sheet& sheet) const {
    std::vector<Index> largest = sheet.triangles;
    std::stable_sort(largest.begin(), largest.end(),
                     [&](Index f, Index g) { return area_of(mesh_, f) > area_of(mesh_, g); });
    largest.resize(std::min<std::size_t>(largest.size(), kSamples));
    std::vector<std::array<Vec3, 2>> points;
    for (const Index f : largest) {
      const Vec3 n = triangle_normal_2a(mesh_.vertices, mesh_.triangles.row(f));
      if (!(n.norm() > 0)) continue;
      const Vec3 step = offset_ * n.normalized(), center = centroid_of(mesh_, f);
      points.push_back({center + step, center - step});
    }
    return points;
  }

  const TriMesh& mesh_;
  WindingNumber winding_;
  std::vector<WindingNumber> removed_;
  double offset_, area_;
  bool balanced_;
};

}  // namespace

Defect remove_inner_sheets(TriMesh& mesh, const Context* ctx) {
  Defect removed;
  for (int round = 0; round < kMaxSheetRounds; ++round) {
    const std::vector<Side> sides = sorted_sides(mesh);
    const std::vector<Sheet> sheets = sheets_of(mesh, sides);
    if (sheets.empty()) break;
    std::vector<char> keep(at(static_cast<Index>(mesh.triangles.rows())), 1);
    SheetJudge judge(mesh, is_balanced(sides));
    Index gone = 0;
    for (const Sheet& sheet : sheets) {
      if (ctx) ctx->checkpoint();
      if (!judge.bounds_nothing(sheet)) continue;
      judge.forget(sheet);
      for (const Index f : sheet.triangles) {
        keep[at(f)] = 0;
        removed.add(centroid_of(mesh, f));
        ++gone;
      }
      if (judge.forgotten() >= kForgottenSheets) break;
    }
    if (gone == 0) break;
    keep_triangles(mesh, keep);
  }
  return removed;
}

}  // namespace s3
