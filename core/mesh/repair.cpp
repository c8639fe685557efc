#include "mesh/repair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "base/error.h"
#include "mesh/fill_holes.h"
#include "mesh/recut_crossings.h"
#include "mesh/repair_sheets.h"
#include "mesh/split_nonmanifold.h"
#include "mesh/stitch.h"
#include "mesh/surface_edges.h"

namespace s3 {

namespace {

constexpr double kShortEdge = 1e-6;     // of the diagonal
constexpr double kFlatTriangle = 1e-9;  // height, of the diagonal
constexpr double kNoVolume = 1e-6;      // of area^(3/2): a sheet
// Of the diagonal and of all volume: a speck, below what any nozzle could print.
constexpr double kSpeckSize = 1e-3, kSpeckVolume = 1e-8;
// A vertex this many times farther out than nearly all others is no coordinate.
constexpr double kFarAway = 1e4;
constexpr double kNearlyAll = 0.9;
// mm, of any file: beyond, products of three coordinates leave the range of exact signs.
constexpr double kLargestCoordinate = 1e15, kSmallestModel = 1e-12;
// A surface whose caps are this large beside itself is a sheet: closing it would invent a shape.
constexpr double kLargestCaps = 0.5;

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

std::string counted(Index n, const std::string& one, const std::string& many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

std::string in_mm(double length) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g mm", length);
  return text;
}

std::string near_place(const std::vector<Vec3>& places) {
  if (places.empty()) return "";
  char text[100];
  std::snprintf(text, sizeof text, " near (%.4g, %.4g, %.4g)", places[0].x(), places[0].y(),
                places[0].z());
  return text;
}

class Repair {
 public:
  Repair(TriMesh surface, Context& ctx) : mesh_(std::move(surface)), ctx_(ctx) {}

  RepairResult run() {
    drop_wild_triangles();
    drop_unused();
    if (mesh_.triangles.rows() == 0) throw_empty();
    diagonal_ = bounding_box(mesh_.vertices).diagonal();
    if (!(diagonal_ > kSmallestModel)) throw_flat({});
    report_ = inspect_surface(mesh_, &ctx_);
    if (report_.valid()) {
      tidy_valid_surface();
    } else {
      close_seams();
      remove_details();
      remove_sheets();
      if (mesh_.triangles.rows() == 0) throw_flat({});
      drop_loose_sheets();
      fill_and_split();
      drop_shells_without_volume();
      turn_shells();
      recut();
      drop_unused();
    }
    return finish();
  }

 private:
  void note(const char* code, std::string sentence, const Defect& defect) {
    if (defect.count > 0)
      changes_.push_back({code, std::move(sentence), defect.count, defect.where});
  }

  [[noreturn]] void throw_empty() const {
    if (changes_.empty())
      throw Error(ErrorKind::input, Stage::mesh, "mesh.empty", "The surface has no triangles",
                  "Export the model with its faces");
    char text[120];
    std::snprintf(text, sizeof text,
                  "The coordinates of all triangles are no numbers or farther out than %.0e mm",
                  kLargestCoordinate);
    throw Error(ErrorKind::input, Stage::mesh, "mesh.too_far_out", text,
                "The file is damaged; export the model again, in millimetres");
  }

  // Coordinates that are no numbers, or lie absurdly far out.
  void drop_wild_triangles() {
    const Eigen::Index n = mesh_.vertices.rows();
    std::vector<char> wild(at(static_cast<Index>(n)), 0);
    std::array<double, 3> low{}, high{};
    for (int k = 0; k < 3; ++k) {
      std::vector<double> values;
      for (Eigen::Index v = 0; v < n; ++v)
        if (std::abs(mesh_.vertices(v, k)) <= kLargestCoordinate)
          values.push_back(mesh_.vertices(v, k));
      if (values.empty()) continue;
      const auto quantile = [&](double q) {
        const auto i = static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
        std::nth_element(values.begin(), values.begin() + i, values.end());
        return values[static_cast<std::size_t>(i)];
      };
      low[at(k)] = quantile(0.5 * (1 - kNearlyAll));
      high[at(k)] = quantile(0.5 * (1 + kNearlyAll));
    }
    const double reach =
        kFarAway * std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
    for (Eigen::Index v = 0; v < n; ++v)
      for (int k = 0; k < 3; ++k) {
        const double x = mesh_.vertices(v, k);
        if (!(std::abs(x) <= kLargestCoordinate) ||
            (reach > 0 && (x < low[at(k)] - reach || x > high[at(k)] + reach)))
          wild[static_cast<std::size_t>(v)] = 1;
      }
    Defect dropped;
    std::vector<char> keep(at(static_cast<Index>(mesh_.triangles.rows())), 1);
    for (Index f = 0; f < mesh_.triangles.rows(); ++f) {
      Vec3 place = Vec3::Zero();
      for (int i = 0; i < 3; ++i) {
        const Index v = mesh_.triangles(f, i);
        if (wild[at(v)])
          keep[at(f)] = 0;
        else
          place = mesh_.vertices.row(v);
      }
      if (!keep[at(f)]) dropped.add(place);
    }
    if (dropped.count > 0) keep_triangles(mesh_, keep);
    note("repair.wild_coordinates",
         counted(dropped.count, "triangle", "triangles") +
             " with a corner that is not a number, or far from everything else, removed",
         dropped);
  }

  void drop_unused() {
    if (const Index n = drop_unused_vertices(mesh_))
      changes_.push_back({"repair.unused_vertices",
                          counted(n, "unused vertex", "unused vertices") + " removed",
                          n,
                          {}});
  }

  // A valid surface may still have details that only cost tets.
  void tidy_valid_surface() {
    const TriMesh as_it_was = mesh_;
    const std::size_t changes = changes_.size();
    remove_details();
    drop_shells_without_volume();
    if (changes_.size() == changes) return;
    drop_unused_vertices(mesh_);
    MeshReport tidied = inspect_surface(mesh_, &ctx_);
    if (tidied.valid()) {
      report_ = std::move(tidied);
    } else {
      mesh_ = as_it_was;
      changes_.resize(changes);
    }
  }

  void close_seams() {
    const Defect welded = weld_equal_vertices(mesh_);
    note("repair.weld",
         counted(welded.count, "vertex", "vertices") +
             " with the coordinates of another joined "
             "with it",
         welded);
    ctx_.checkpoint();
    const Stitched stitched = stitch_open_edges(mesh_, &ctx_);
    note("repair.stitch",
         counted(stitched.joined.count, "vertex", "vertices") +
             " of open edges joined over up to " + in_mm(stitched.widest),
         stitched.joined);
    note("repair.split_edges",
         counted(stitched.split.count, "open edge", "open edges") +
             " split at a vertex that lay on them",
         stitched.split);
    ctx_.checkpoint();
  }

  void remove_details() {
    const Defect shorts = collapse_short_edges(mesh_, kShortEdge * diagonal_);
    note("repair.short_edges",
         counted(shorts.count, "edge", "edges") + " shorter than " + in_mm(kShortEdge * diagonal_) +
             " collapsed",
         shorts);
    const Defect flat = remove_flat_triangles(mesh_, kFlatTriangle * diagonal_);
    note("repair.flat_triangles",
         counted(flat.count, "triangle", "triangles") + " without area removed", flat);
    ctx_.checkpoint();
  }

  void remove_sheets() {
    const Defect duplicates = remove_duplicate_triangles(mesh_);
    note("repair.duplicates",
         counted(duplicates.count, "triangle", "triangles") +
             " that doubled another, or made a wall or flap of no thickness, removed",
         duplicates);
    Defect turned = turn_to_neighbours(mesh_);
    if (has_crowded_edges()) {
      turn_crowded_parts_outward();
      const Defect inner = remove_inner_sheets(mesh_, &ctx_);
      note("repair.inner_walls",
           counted(inner.count, "triangle", "triangles") +
               " with solid, or nothing, on both sides removed",
           inner);
      const Defect again = turn_to_neighbours(mesh_);
      turned.count += again.count;
      turned.where.insert(turned.where.end(), again.where.begin(), again.where.end());
    }
    note("repair.turn",
         counted(turned.count, "triangle", "triangles") + " turned to face as their neighbours do",
         turned);
    ctx_.checkpoint();
  }

  bool has_crowded_edges() const {
    bool crowded = false;
    for_each_edge(sorted_sides(mesh_), [&](std::size_t begin, std::size_t end) {
      crowded = crowded || end - begin > 2;
    });
    return crowded;
  }

  // Winding numbers mean something only where the surface faces outward on the whole.
  void turn_crowded_parts_outward() {
    const std::vector<Side> sides = sorted_sides(mesh_);
    Index count = 0;
    const std::vector<Index> part = connected_parts(mesh_, sides, false, count);
    std::vector<double> volume(at(count), 0);
    std::vector<char> crowded(at(count), 0);
    for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
      if (end - begin > 2) crowded[at(part[at(sides[begin].triangle())])] = 1;
    });
    const Vec3 middle = mesh_.vertices.colwise().mean();
    for (Index f = 0; f < mesh_.triangles.rows(); ++f)
      volume[at(part[at(f)])] +=
          (centroid_of(mesh_, f) - middle)
              .dot(triangle_normal_2a(mesh_.vertices, mesh_.triangles.row(f)));
    Defect turned;
    for (Index f = 0; f < mesh_.triangles.rows(); ++f)
      if (crowded[at(part[at(f)])] && volume[at(part[at(f)])] < 0) {
        std::swap(mesh_.triangles(f, 1), mesh_.triangles(f, 2));
        turned.add(centroid_of(mesh_, f));
      }
    note("repair.turn_shells",
         counted(turned.count, "triangle", "triangles") + " of an inside-out part turned", turned);
  }

  struct Attempt {
    TriMesh mesh;
    FilledHoles filled;
    Defect doubled;
    MeshReport report;
  };

  Attempt attempt(bool fill, bool fair) {
    Attempt a;
    a.mesh = mesh_;
    if (fill) a.filled = fill_holes(a.mesh, fair, ctx_);
    a.doubled = split_nonmanifold(a.mesh);
    a.report = inspect_split(a.mesh, &ctx_);
    return a;
  }

  // Open parts that enclose nothing, even when closed; not if that is all there is.
  void drop_loose_sheets() {
    const std::vector<Side> sides = sorted_sides(mesh_);
    Index count = 0;
    const std::vector<Index> part = connected_parts(mesh_, sides, false, count);
    if (count < 2) return;
    std::vector<char> open(at(count), 0);
    for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
      if (end - begin == 1) open[at(part[at(sides[begin].triangle())])] = 1;
    });
    if (std::none_of(open.begin(), open.end(), [](char o) { return o; })) return;
    TriMesh closed = mesh_;
    fill_holes(closed, false, ctx_);
    Index closed_count = 0;
    const std::vector<Index> closed_part =
        connected_parts(closed, sorted_sides(closed), false, closed_count);
    std::vector<Vec3> place(at(closed_count));
    std::vector<double> area(at(closed_count), 0), volume(at(closed_count), 0);
    for (Index f = 0; f < closed.triangles.rows(); ++f) {
      const auto p = at(closed_part[at(f)]);
      const Vec3 normal = 0.5 * triangle_normal_2a(closed.vertices, closed.triangles.row(f));
      if (area[p] == 0) place[p] = centroid_of(closed, f);
      area[p] += normal.norm();
      volume[p] += normal.dot(centroid_of(closed, f) - place[p]) / 3;
    }
    const auto is_flat = [&](std::size_t p) {
      return std::abs(volume[p]) <= kNoVolume * area[p] * std::sqrt(area[p]);
    };
    std::vector<char> keep(part.size(), 1);
    Defect sheets;
    std::vector<char> seen(at(count), 0);
    Index solid = 0;
    for (std::size_t f = 0; f < part.size(); ++f) {
      keep[f] = !open[at(part[f])] || !is_flat(at(closed_part[f]));
      if (seen[at(part[f])]++) continue;
      if (keep[f])
        ++solid;
      else
        sheets.add(centroid_of(mesh_, static_cast<Index>(f)));
    }
    if (sheets.count == 0 || solid == 0) return;
    keep_triangles(mesh_, keep);
    note("repair.flat_shells",
         counted(sheets.count, "loose sheet", "loose sheets") + " without thickness removed",
         sheets);
  }

  void fill_and_split() {
    Attempt best = attempt(true, true);
    const auto worse = [](const Attempt& a, const Attempt& b) {
      return a.report.self_intersections.count > b.report.self_intersections.count ||
             a.report.duplicate_triangles.count > b.report.duplicate_triangles.count;
    };
    if (best.filled.flat.count + best.filled.curved.count > 0 && !best.report.valid()) {
      Attempt open = attempt(false, false);
      if (worse(best, open)) {
        Attempt plain = attempt(true, false);
        if (plain.report.self_intersections.count < best.report.self_intersections.count)
          best = std::move(plain);
        if (worse(best, open)) {
          best = std::move(open);
          reason_ = "its holes cannot be closed without crossing the surface";
        }
      }
    }
    if (best.report.open_edges.count > 0) refuse_sheet();
    mesh_ = std::move(best.mesh);
    report_ = std::move(best.report);
    note("repair.holes_flat",
         counted(best.filled.flat.count, "hole", "holes") + " filled with flat faces" +
             largest(best.filled, best.filled.curved.count == 0),
         best.filled.flat);
    note("repair.holes_curved",
         counted(best.filled.curved.count, "hole", "holes") + " filled with curved faces" +
             largest(best.filled, true),
         best.filled.curved);
    note("repair.split",
         counted(best.doubled.count, "vertex", "vertices") +
             " doubled where parts touch in an edge or a point only",
         best.doubled);
    ctx_.checkpoint();
  }

  static std::string largest(const FilledHoles& filled, bool say) {
    return say ? ", the largest " + in_mm(filled.largest) + " across" : "";
  }

  void drop_shells_without_volume() {
    const Shells shells = measure_shells(mesh_);
    std::vector<double> area(shells.shells.size(), 0);
    std::vector<Box> box(shells.shells.size());
    std::vector<char> closed(shells.shells.size(), 1), drop(shells.shells.size(), 0);
    for (Index f = 0; f < mesh_.triangles.rows(); ++f) {
      const auto s = at(shells.of_triangle[at(f)]);
      if (area[s] == 0) box[s].min = box[s].max = centroid_of(mesh_, f);
      area[s] += 0.5 * triangle_normal_2a(mesh_.vertices, mesh_.triangles.row(f)).norm();
      for (int i = 0; i < 3; ++i) {
        const Vec3 p = mesh_.vertices.row(mesh_.triangles(f, i));
        box[s].min = box[s].min.cwiseMin(p);
        box[s].max = box[s].max.cwiseMax(p);
      }
    }
    const std::vector<Side> sides = sorted_sides(mesh_);
    for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
      if (end - begin != 2 || sides[begin].forward == sides[begin + 1].forward)
        closed[at(shells.of_triangle[at(sides[begin].triangle())])] = 0;
    });
    double largest = 0;
    for (const Shell& shell : shells.shells) largest = std::max(largest, std::abs(shell.volume));
    Defect flat, specks;
    for (std::size_t s = 0; s < drop.size(); ++s) {
      const double volume = std::abs(shells.shells[s].volume);
      if (!closed[s]) continue;
      if (volume <= kNoVolume * area[s] * std::sqrt(area[s]))
        flat.add(shells.shells[s].place);
      else if (volume <= kSpeckVolume * largest && box[s].diagonal() <= kSpeckSize * diagonal_)
        specks.add(shells.shells[s].place);
      else
        continue;
      drop[s] = 1;
    }
    if (flat.count + specks.count == 0) return;
    if (flat.count == static_cast<Index>(drop.size())) throw_flat(flat);
    std::vector<char> keep(shells.of_triangle.size());
    for (std::size_t f = 0; f < keep.size(); ++f) keep[f] = !drop[at(shells.of_triangle[f])];
    keep_triangles(mesh_, keep);
    drop_unused_vertices(mesh_);
    note("repair.flat_shells",
         counted(flat.count, "loose piece", "loose pieces") + " without volume removed", flat);
    note("repair.specks",
         counted(specks.count, "loose speck", "loose specks") + " too small to print removed",
         specks);
    report_ = inspect_split(mesh_, &ctx_);
  }

  // What stays open may be a solid with a gap, or no solid at all.
  void refuse_sheet() const {
    TriMesh closed = mesh_;
    const FilledHoles filled = fill_holes(closed, false, ctx_);
    if (filled.area <= kLargestCaps * surface_area(mesh_)) return;
    std::vector<Vec3> places;
    for (const Defect* holes : {&filled.flat, &filled.curved, &filled.left_open})
      places.insert(places.end(), holes->where.begin(), holes->where.end());
    throw Error(ErrorKind::input, Stage::mesh, "mesh.open_surface",
                "The surface is an open sheet and encloses nothing: its hole, " +
                    in_mm(filled.largest) + " across" + near_place(places) +
                    ", is about as large as the surface itself",
                "Give it a bottom in your CAD or mesh program, or a thickness by "
                "input.sheet_thickness",
                places);
  }

  [[noreturn]] void throw_flat(const Defect& flat) const {
    char text[200];
    std::snprintf(text, sizeof text,
                  "The surface encloses no volume: it is a sheet without thickness, or encloses as "
                  "much inside out as outward; it is %.4g mm across",
                  diagonal_);
    throw Error(ErrorKind::input, Stage::mesh, "mesh.no_volume", text,
                "Give it a thickness in your CAD or mesh program, or by input.sheet_thickness",
                flat.where);
  }

  // Outward; inward inside another shell. Shells that cross another are bodies that overlap.
  void turn_shells() {
    const Shells shells = measure_shells(mesh_);
    if (!is_closed_and_oriented(sorted_sides(mesh_))) return;
    std::vector<char> crossing(shells.shells.size(), 0), turn(shells.shells.size(), 0);
    for (const auto& [f, g] : report_.intersecting_pairs)
      if (shells.of_triangle[at(f)] != shells.of_triangle[at(g)])
        crossing[at(shells.of_triangle[at(f)])] = crossing[at(shells.of_triangle[at(g)])] = 1;
    Defect outward, cavities;
    for (std::size_t s = 0; s < turn.size(); ++s) {
      const Shell& shell = shells.shells[s];
      const bool cavity = shell.depth % 2 == 1 && !crossing[s];
      if ((shell.volume < 0) == cavity) continue;
      turn[s] = 1;
      (cavity ? cavities : outward).add(shell.place);
    }
    if (outward.count + cavities.count == 0) return;
    for (Index f = 0; f < mesh_.triangles.rows(); ++f)
      if (turn[at(shells.of_triangle[at(f)])])
        std::swap(mesh_.triangles(f, 1), mesh_.triangles(f, 2));
    note("repair.turn_shells",
         counted(outward.count, "shell that was", "shells that were") + " inside out turned",
         outward);
    note("repair.cavities",
         counted(cavities.count, "body", "bodies") + " inside another taken for a cavity",
         cavities);
    if (cavities.count > 0)
      ctx_.warn("mesh.nested_body",
                counted(cavities.count, "closed shell lies", "closed shells lie") +
                    " inside another and became a cavity; remove it from the file if the part is "
                    "solid there",
                cavities.where);
    report_ = inspect_split(mesh_, &ctx_);
  }

  void recut() {
    if (report_.self_intersections.count == 0 || !reason_.empty()) return;
    std::optional<Recut> cut = recut_crossings(mesh_, report_, ctx_);
    if (!cut) return;
    mesh_ = std::move(cut->surface);
    report_ = std::move(cut->report);
    char share[48];
    std::snprintf(share, sizeof share, " (%.2g %% of the area)", 100 * cut->area_share);
    note("repair.crossings",
         counted(cut->removed.count, "triangle", "triangles") + share +
             " at places where the surface crossed itself replaced",
         cut->removed);
  }

  RepairResult finish() {
    RepairResult result;
    result.valid = report_.valid();
    if (!result.valid) result.reason = reason_.empty() ? reason() : reason_;
    result.surface = std::move(mesh_);
    result.changes = std::move(changes_);
    result.report = std::move(report_);
    return result;
  }

  std::string reason() const {
    const MeshReport& r = report_;
    if (r.self_intersections.count >= MeshReport::kMaxIntersections)
      return std::to_string(r.self_intersections.count) + " or more pairs of its triangles cross";
    if (r.self_intersections.count > 0)
      return counted(r.self_intersections.count, "pair", "pairs") + " of its triangles cross";
    if (r.open_edges.count > 0)
      return counted(r.open_edges.count, "edge", "edges") + " could not be closed";
    if (r.inconsistent_edges.count > 0) return "it has one side only, as a Möbius strip";
    if (r.nonmanifold_edges.count + r.nonmanifold_vertices.count > 0)
      return "its parts cannot be told apart where they touch";
    return counted(r.degenerate_triangles.count + r.duplicate_triangles.count, "triangle",
                   "triangles") +
           " without area could not be removed";
  }

  TriMesh mesh_;
  Context& ctx_;
  double diagonal_ = 0;
  std::vector<RepairChange> changes_;
  MeshReport report_;
  std::string reason_;
};

}  // namespace

RepairResult repair_surface(TriMesh surface, Context& ctx) {
  return Repair(std::move(surface), ctx).run();
}

}  // namespace s3
