// The only file that knows TetGen: H. Si, "TetGen, a Delaunay-Based Quality Tetrahedral Mesh
// Generator", ACM TOMS 41(2), 2015.
#include "tetrahedralize/tetgen_backend.h"

#ifdef S3_WITH_TETGEN

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <new>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <hooks.h>
#include <tetgen.h>

#include "mesh/reorder.h"

namespace s3 {

namespace tetgen {
namespace {

constexpr int kOutOfMemory = 1;

// One run of TetGen. It throws through functions that hold memory (cancelled, or failed): what is
// left of that is freed here.
class Run {
 public:
  explicit Run(const Context& ctx) : ctx_(ctx) { current() = this; }
  ~Run() {
    while (first_.next != &first_) release(first_.next + 1);
    current() = nullptr;
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  /// The run of this thread.
  static Run*& current() {
    thread_local Run* run = nullptr;
    return run;
  }

  void* allocate(std::size_t bytes) {
    auto* block = static_cast<Block*>(std::malloc(sizeof(Block) + bytes));
    if (block == nullptr) throw kOutOfMemory;
    *block = {first_.next, &first_};
    block->next->previous = block->previous->next = block;
    return block + 1;
  }

  static void release(void* memory) {
    Block* const block = static_cast<Block*>(memory) - 1;
    block->previous->next = block->next;
    block->next->previous = block->previous;
    std::free(block);
  }

  void checkpoint() {
    constexpr unsigned kCalls = 64;  // some microseconds each
    if (++calls_ % kCalls == 0) ctx_.checkpoint();
  }

 private:
  struct alignas(std::max_align_t) Block {
    Block *next, *previous;
  };

  const Context& ctx_;
  unsigned calls_ = 0;
  Block first_{&first_, &first_};
};

}  // namespace

void* allocate(std::size_t bytes) {
  return Run::current()->allocate(bytes);
}

void release(void* block) {
  if (block != nullptr) Run::release(block);
}

void checkpoint() {
  Run::current()->checkpoint();
}

}  // namespace tetgen

namespace {

// Shape: circumradius to shortest edge at most 1.4, and no dihedral angle below 10° where the
// surface allows; what stays worse, or over 150°, is worked on by flips, smoothing and splits.
constexpr const char* kShapeSwitches = "q1.4/10o/150O5/7";
// The count must come this near to the target; TetGen runs at most this often to get there.
constexpr double kCountTolerance = 0.15;
constexpr int kMaxRuns = 4;
// Measured on smooth shapes: a volume limit a gives about 1.65 V/a tets, and the layer of tets
// along a kept surface adds kTetsPerTriangle for each of its triangles.
constexpr double kTetsPerVolume = 1.65;
// Triangles of a kept surface may be this much larger than the faces of the tets behind them.
constexpr double kCoarseTriangle = 4.0;

struct RawTets {
  Points vertices;
  Tets tets;
};

// TetGen keeps its exact predicates in static variables: one run at a time.
std::mutex& tetgen_mutex() {
  static std::mutex mutex;
  return mutex;
}

constexpr int kTooFlat = -1;  // not TetGen's own: it ended well, but with flat tets

[[noreturn]] void throw_failed(const std::string& message, const std::string& hint) {
  throw Error(ErrorKind::slicing, Stage::tetrahedralize, "tetrahedralize.failed", message, hint);
}

// TetGen's exit codes in words.
[[noreturn]] void throw_failure(int code) {
  const std::string hint =
      "Look for parts that overlap, touch or nearly touch, and join or separate them in your CAD "
      "program";
  const std::string failed = "The surface cannot be filled with tets: ";
  switch (code) {
    case tetgen::kOutOfMemory:
      throw_failed("There is not enough memory for the tet mesh",
                   "Ask for fewer tets with mesh.target_tets");
    case 3:
      throw_failed(failed + "it intersects itself", hint);
    case 4:
      throw_failed(failed + "it has a detail too small to resolve", hint);
    case kTooFlat:
      throw_failed(failed + "some of them would be flat", hint);
    case 5:
      throw_failed(failed + "two of its parts nearly coincide", hint);
    default:
      throw_failed(failed + "TetGen stopped with code " + std::to_string(code), hint);
  }
}

[[noreturn]] void throw_empty() {
  throw Error(ErrorKind::slicing, Stage::tetrahedralize, "tetrahedralize.empty",
              "The surface encloses no volume",
              "Check that the surface is closed and that its triangles face outward");
}

// Arrays handed over here are freed by the destructor of tetgenio.
void set_surface(const TriMesh& surface, tetgenio& in) {
  in.firstnumber = 0;
  in.numberofpoints = static_cast<int>(surface.vertices.rows());
  in.pointlist = new double[static_cast<std::size_t>(surface.vertices.size())];
  std::copy_n(surface.vertices.data(), surface.vertices.size(), in.pointlist);

  const auto n = static_cast<std::size_t>(surface.triangles.rows());
  in.numberoffacets = static_cast<int>(n);
  in.facetlist = new tetgenio::facet[n];
  in.facetmarkerlist = new int[n];
  for (std::size_t f = 0; f < n; ++f) {
    tetgenio::facet& facet = in.facetlist[f];
    tetgenio::init(&facet);
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    tetgenio::polygon& polygon = facet.polygonlist[0];
    tetgenio::init(&polygon);
    polygon.numberofvertices = 3;
    polygon.vertexlist = new int[3];
    for (int i = 0; i < 3; ++i)
      polygon.vertexlist[i] = surface.triangles(static_cast<Eigen::Index>(f), i);
    in.facetmarkerlist[f] = static_cast<int>(f) + 1;
  }
}

// A boundary face of TetGen's mesh, or a tet's face, with sorted corners.
struct SharedFace {
  std::array<int, 3> corners;
  int owner;  // tet or boundary face
  int local;  // face of the tet, −1 for a boundary face
  bool operator<(const SharedFace& o) const {
    return corners != o.corners ? corners < o.corners
                                : std::pair(local < 0, owner) < std::pair(o.local < 0, o.owner);
  }
};

std::array<int, 3> sorted(int a, int b, int c) {
  std::array<int, 3> corners{a, b, c};
  std::sort(corners.begin(), corners.end());
  return corners;
}

// How often the surface winds around each region of TetGen's mesh, found by walking from the
// outside inwards: crossing a face against its normal adds one. Regions are numbered from 1 in
// `tetrahedronattributelist`.
std::vector<int> winding_of_regions(const TriMesh& surface, const tetgenio& out) {
  std::vector<SharedFace> faces;
  for (int t = 0; t < out.numberoftetrahedra; ++t)
    for (int f = 0; f < 4; ++f) {
      const int* corner = out.tetrahedronlist + 4 * t;
      faces.push_back(
          {sorted(corner[kTetFaces[f][0]], corner[kTetFaces[f][1]], corner[kTetFaces[f][2]]), t,
           f});
    }
  for (int b = 0; b < out.numberoftrifaces; ++b) {
    const int* corner = out.trifacelist + 3 * b;
    faces.push_back({sorted(corner[0], corner[1], corner[2]), b, -1});
  }
  std::sort(faces.begin(), faces.end());

  const auto region_of = [&](int t) {
    return static_cast<int>(std::lround(out.tetrahedronattributelist[t]));
  };
  int regions = 0;
  for (int t = 0; t < out.numberoftetrahedra; ++t) regions = std::max(regions, region_of(t));

  // step[from][to] = winding of `to` minus winding of `from`; region 0 is the outside.
  const auto count = static_cast<std::size_t>(regions) + 1;
  std::vector<std::vector<std::pair<int, int>>> steps(count);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (faces[i].local < 0) continue;
    std::size_t end = i + 1;
    while (end < faces.size() && faces[end].corners == faces[i].corners) ++end;
    const SharedFace& last = faces[end - 1];
    if (last.local < 0) {
      const int marker = out.trifacemarkerlist[last.owner];
      const Vec3 normal = triangle_normal_2a(surface.vertices, surface.triangles.row(marker - 1));
      const int t = faces[i].owner;
      const Eigen::Map<const Points> points(out.pointlist, out.numberofpoints, 3);
      const Vec3 to_apex = (points.row(out.tetrahedronlist[4 * t + faces[i].local]) -
                            points.row(faces[i].corners[0]))
                               .transpose();
      const int first = region_of(t), second = end - i == 3 ? region_of(faces[i + 1].owner) : 0;
      const int step = normal.dot(to_apex) > 0 ? 1 : -1;  // into `second`
      auto& known = steps[static_cast<std::size_t>(first)];
      if (std::find(known.begin(), known.end(), std::pair(second, step)) == known.end()) {
        known.emplace_back(second, step);
        steps[static_cast<std::size_t>(second)].emplace_back(first, -step);
      }
    }
    i = end - 1;
  }

  std::vector<int> winding(count, 0), queue{0};
  std::vector<char> seen(count, 0);
  seen[0] = 1;
  for (std::size_t head = 0; head < queue.size(); ++head)
    for (const auto& [next, step] : steps[static_cast<std::size_t>(queue[head])])
      if (!seen[static_cast<std::size_t>(next)]) {
        seen[static_cast<std::size_t>(next)] = 1;
        winding[static_cast<std::size_t>(next)] =
            winding[static_cast<std::size_t>(queue[head])] + step;
        queue.push_back(next);
      }
  return winding;
}

// TetGen's points and tets without the tets in cavities, and without points that no tet uses.
RawTets collect(const tetgenio& out, const std::vector<int>& winding) {
  const auto inside = [&](int t) {
    return winding.empty() ||
           winding[static_cast<std::size_t>(std::lround(out.tetrahedronattributelist[t]))] > 0;
  };
  std::vector<Index> new_index(static_cast<std::size_t>(out.numberofpoints), -1);
  Index points = 0;
  Eigen::Index tets = 0;
  for (int t = 0; t < out.numberoftetrahedra; ++t) {
    if (!inside(t)) continue;
    ++tets;
    for (int i = 0; i < 4; ++i) {
      Index& index = new_index[static_cast<std::size_t>(out.tetrahedronlist[4 * t + i])];
      if (index < 0) index = points++;
    }
  }
  RawTets raw{Points(points, 3), Tets(tets, 4)};
  for (std::size_t v = 0; v < new_index.size(); ++v)
    if (new_index[v] >= 0)
      raw.vertices.row(new_index[v]) << out.pointlist[3 * v], out.pointlist[3 * v + 1],
          out.pointlist[3 * v + 2];
  Eigen::Index row = 0;
  for (int t = 0; t < out.numberoftetrahedra; ++t) {
    if (!inside(t)) continue;
    for (int i = 0; i < 4; ++i)
      raw.tets(row, i) = new_index[static_cast<std::size_t>(out.tetrahedronlist[4 * t + i])];
    ++row;
  }
  return raw;
}

// How TetGen is asked, apart from the volume limit.
struct Way {
  bool keep_surface;  // no new vertices on the surface
  bool good_shape;    // kShapeSwitches; otherwise only the volume limit refines
};

// Nearly flat tets are no use to anybody: their gradients are noise.
bool has_flat_tets(const RawTets& raw) {
  constexpr double kFlat = 1e-12;  // of the longest edge's cube
  for (Index t = 0; t < raw.tets.rows(); ++t) {
    double longest = 0;
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j)
        longest = std::max(
            longest,
            (raw.vertices.row(raw.tets(t, i)) - raw.vertices.row(raw.tets(t, j))).squaredNorm());
    if (std::abs(tet_volume(raw.vertices, raw.tets, t)) <= kFlat * longest * std::sqrt(longest))
      return true;
  }
  return false;
}

// @throws int as TetGen does, Cancelled
RawTets run_tetgen(const TriMesh& surface, double max_volume, bool has_cavities, const Way& way,
                   const Context& ctx) {
  tetgenio in, out;
  set_surface(surface, in);
  std::array<char, 96> switches{};
  std::snprintf(switches.data(), switches.size(), "p%s%sa%.9e%sQ", way.keep_surface ? "Y" : "",
                way.good_shape ? kShapeSwitches : "", max_volume, has_cavities ? "A" : "");
  {
    const std::lock_guard lock(tetgen_mutex());
    const tetgen::Run run(ctx);
    ::tetrahedralize(switches.data(), &in, &out);
  }
  if (out.numberoftetrahedra == 0) throw_empty();
  RawTets raw = collect(out, has_cavities ? winding_of_regions(surface, out) : std::vector<int>());
  if (has_flat_tets(raw)) throw kTooFlat;
  return raw;
}

// Tries one way after the other. A way that failed is removed from `ways` for later runs.
RawTets run_some_way(const TriMesh& surface, double max_volume, bool has_cavities,
                     std::vector<Way>& ways, const Context& ctx) {
  for (;;) {
    try {
      return run_tetgen(surface, max_volume, has_cavities, ways.front(), ctx);
    } catch (int code) {
      if (code == tetgen::kOutOfMemory || ways.size() == 1) throw_failure(code);
      ways.erase(ways.begin());
    } catch (const std::bad_alloc&) {
      throw_failure(tetgen::kOutOfMemory);
    }
  }
}

// True where most of the surface is made of triangles no larger than tets of the wanted size ask
// for.
bool is_fine_enough(const TriMesh& surface, double tet_volume) {
  double area = 0, square = 0;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const double a = 0.5 * triangle_normal_2a(surface.vertices, surface.triangles.row(f)).norm();
    area += a;
    square += a * a;
  }
  const double edge = std::cbrt(6.0 * std::numbers::sqrt2 * tet_volume);  // V = edge³/(6√2)
  const double face = std::numbers::sqrt3 / 4.0 * edge * edge;
  return square <= kCoarseTriangle * face * area;
}

// True where some connected part of the surface is turned inside out, that is, bounds a cavity.
bool has_inverted_shell(const TriMesh& surface) {
  std::vector<Index> parent(static_cast<std::size_t>(surface.vertices.rows()));
  for (std::size_t v = 0; v < parent.size(); ++v) parent[v] = static_cast<Index>(v);
  const auto root = [&](Index v) {
    while (parent[static_cast<std::size_t>(v)] != v) {
      Index& up = parent[static_cast<std::size_t>(v)];
      up = parent[static_cast<std::size_t>(up)];
      v = up;
    }
    return v;
  };
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f)
    for (int i = 1; i < 3; ++i)
      parent[static_cast<std::size_t>(root(surface.triangles(f, i)))] =
          root(surface.triangles(f, 0));
  std::vector<double> six_volume(parent.size(), 0.0);
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const Vec3 a = surface.vertices.row(surface.triangles(f, 0)),
               b = surface.vertices.row(surface.triangles(f, 1)),
               c = surface.vertices.row(surface.triangles(f, 2));
    six_volume[static_cast<std::size_t>(root(surface.triangles(f, 0)))] += a.dot(b.cross(c));
  }
  return std::any_of(six_volume.begin(), six_volume.end(), [](double v) { return v < 0; });
}

}  // namespace

bool has_tetgen() {
  return true;
}

TetMesh fill_with_tetgen(const TriMesh& surface, int target_tets, Context& ctx) {
  const double volume = enclosed_volume(surface);
  if (!(volume > 0) || surface.triangles.rows() < 4) throw_empty();
  ctx.progress(Stage::tetrahedralize, 0.0);

  const double target = target_tets;
  const auto triangles = static_cast<double>(surface.triangles.rows());
  const bool keep = is_fine_enough(surface, volume / target);
  std::vector<Way> ways{{keep, true}, {!keep, true}, {keep, false}, {!keep, false}};
  const bool has_cavities = has_inverted_shell(surface);
  const double largest = 10.0 * kTetsPerVolume * volume / target;  // of the limits to try
  const double inner_target = target - (keep ? kTetsPerTriangle * triangles : 0.0);
  double max_volume =
      inner_target > 0.1 * target ? kTetsPerVolume * volume / inner_target : largest;

  RawTets best;
  double best_miss = std::numeric_limits<double>::infinity();
  double last_inverse = 0, last_count = 0;
  for (int i = 0; i < kMaxRuns; ++i) {
    RawTets raw = run_some_way(surface, max_volume, has_cavities, ways, ctx);
    ctx.progress(Stage::tetrahedralize, (i + 1.0) / (kMaxRuns + 1.0));
    const auto count = static_cast<double>(raw.tets.rows());
    const double miss = std::abs(std::log(count / target));
    if (miss < best_miss) {
      best_miss = miss;
      best = std::move(raw);
    }
    if (std::abs(count - target) <= kCountTolerance * target) break;
    const bool no_effect = i > 0 && std::abs(count - last_count) < 0.01 * count;
    if (count > target && (no_effect || max_volume >= largest)) break;  // the surface needs more
    // The count grows along a line over the inverse of the limit: the secant finds the next one.
    const double inverse = 1.0 / max_volume;
    const double slope = i == 0 || last_inverse == inverse
                             ? kTetsPerVolume * volume
                             : (count - last_count) / (inverse - last_inverse);
    last_inverse = inverse;
    last_count = count;
    const double next = slope > 0 ? inverse + (target - count) / slope : 0.0;
    max_volume = next > 0
                     ? std::clamp(1.0 / next, max_volume / 8.0, std::min(largest, 8.0 * max_volume))
                     : std::min(largest, 8.0 * max_volume);
  }

  const auto count = static_cast<double>(best.tets.rows());
  if (count > (1.0 + kCountTolerance) * target)
    ctx.warn("tetrahedralize.more_tets",
             "The mesh has " + std::to_string(best.tets.rows()) + " tets instead of " +
                 std::to_string(target_tets) + ": the surface with its " +
                 std::to_string(surface.triangles.rows()) + " triangles needs that many");
  else if (count < (1.0 - kCountTolerance) * target)
    ctx.warn("tetrahedralize.fewer_tets", "The mesh has " + std::to_string(best.tets.rows()) +
                                              " tets instead of " + std::to_string(target_tets));
  ctx.checkpoint();
  TetMesh mesh = make_tet_mesh(std::move(best.vertices), std::move(best.tets));
  ctx.checkpoint();
  mesh = reorder_along_morton(mesh);
  ctx.progress(Stage::tetrahedralize, 1.0);
  return mesh;
}

}  // namespace s3

#else

namespace s3 {

bool has_tetgen() {
  return false;
}

TetMesh fill_with_tetgen(const TriMesh&, int, Context&) {
  throw Error(ErrorKind::slicing, Stage::tetrahedralize, "tetrahedralize.unavailable",
              "This build was made without TetGen",
              "Set mesh.backend to auto or stuffing, or build with -DS3_WITH_TETGEN=ON");
}

}  // namespace s3

#endif
