// Garanzha, Kaporin, Kudryavtseva, Protais, Ray, Sokolov: "Foldover-free maps in 50 lines of code",
// ACM TOG 40(4), 2021. Minimises Σ_e V_e (tr FᵀF / χ^⅔ + λ (det² F + 1) / χ) with χ(ε, D) = (D +
// √(ε² + D²)) / 2, a regularised determinant that is positive for inverted tets too and tends to
// max(D, 0) as ε falls.
#include "deformation/foldover.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

namespace s3 {

namespace {

constexpr double kSizeWeight = 0.1;  // λ

double regularised(double epsilon, double D) {
  const double root = std::sqrt(epsilon * epsilon + D * D);
  // For D < 0 the printed form cancels; both are equal.
  return D > 0 ? 0.5 * (D + root) : 0.5 * epsilon * epsilon / (root - D);
}

// The free vertices and all tets that they touch.
struct Patch {
  std::vector<Index> vertices;  // free
  std::vector<Index> tets;
  std::vector<Eigen::Matrix<double, 3, 4>> gradients;  // hat gradients of `tets`
  std::vector<double> weight;                          // rest volume, relative
  std::vector<char> fixed_z;                           // of `vertices`
};

struct Energy {
  double value = 0;
  double least_det = std::numeric_limits<double>::infinity();
};

class Unfolder {
 public:
  Unfolder(const TetMesh& rest, Patch patch, Points& positions)
      : rest_(rest), patch_(std::move(patch)), positions_(positions) {
    slot_.assign(static_cast<std::size_t>(rest.vertex_count()), -1);
    for (std::size_t i = 0; i < patch_.vertices.size(); ++i)
      slot_[patch_.vertices[i]] = static_cast<Index>(i);
  }

  // Returns whether every tet of the patch is unfolded; moves the positions in any case.
  bool run(Context& ctx) {
    constexpr int kRounds = 60;
    Energy now = evaluate(std::numeric_limits<double>::quiet_NaN(), nullptr);
    double epsilon = start_epsilon(now.least_det);
    now = evaluate(epsilon, nullptr);
    for (int round = 0; round < kRounds; ++round) {
      ctx.checkpoint();
      if (now.least_det > kLeastVolumeShare) return true;
      const double before = now.value;
      now = minimise(epsilon);
      epsilon = next_epsilon(epsilon, now, before);
      now = evaluate(epsilon, nullptr);
    }
    return now.least_det > kLeastVolumeShare;
  }

 private:
  static double start_epsilon(double least_det) {
    return std::sqrt(1e-12 + 0.04 * std::min(least_det, 0.0) * std::min(least_det, 0.0));
  }

  // The paper's rule, which reaches an untangled map in finitely many steps if the minimiser makes
  // progress.
  static double next_epsilon(double epsilon, const Energy& now, double before) {
    const double progress = std::max(0.1, 1 - now.value / before);
    const double mu = (1 - progress) * regularised(epsilon, now.least_det);
    if (now.least_det >= mu) return 1e-6;
    return 2 * std::sqrt(mu * (mu - now.least_det));
  }

  Mat3 deformation_gradient(std::size_t i) const {
    Eigen::Matrix<double, 3, 4> corners;
    for (int k = 0; k < 4; ++k) corners.col(k) = positions_.row(rest_.tets(patch_.tets[i], k));
    return corners * patch_.gradients[i].transpose();
  }

  // Energy and, unless null, its gradient for the free vertices (#×3). With ε = NaN only least_det
  // is of use.
  Energy evaluate(double epsilon, Points* gradient) const {
    Energy energy;
    if (gradient) gradient->setZero(static_cast<Eigen::Index>(patch_.vertices.size()), 3);
    for (std::size_t i = 0; i < patch_.tets.size(); ++i) {
      const Mat3 F = deformation_gradient(i);
      Mat3 cofactor;
      cofactor << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
      const double D = F.col(0).dot(cofactor.col(0));
      const double chi = regularised(epsilon, D), third = std::cbrt(chi);
      const double shape = F.squaredNorm() / (third * third), size = (D * D + 1) / chi;
      energy.value += patch_.weight[i] * (shape + kSizeWeight * size);
      energy.least_det = std::min(energy.least_det, D);
      if (!gradient) continue;
      const double slope = chi / std::sqrt(epsilon * epsilon + D * D);  // dχ/dD
      const Mat3 dF =
          2 / (third * third) * F -
          (2.0 / 3 * shape * slope / chi + kSizeWeight * (size * slope - 2 * D) / chi) * cofactor;
      const Eigen::Matrix<double, 3, 4> force = patch_.weight[i] * dF * patch_.gradients[i];
      for (int k = 0; k < 4; ++k) {
        const Index slot = slot_[rest_.tets(patch_.tets[i], k)];
        if (slot >= 0) gradient->row(slot) += force.col(k).transpose();
      }
    }
    if (gradient)
      for (std::size_t i = 0; i < patch_.vertices.size(); ++i)
        if (patch_.fixed_z[i]) (*gradient)(static_cast<Eigen::Index>(i), 2) = 0;
    return energy;
  }

  void move_to(const Points& x) {
    for (std::size_t i = 0; i < patch_.vertices.size(); ++i)
      positions_.row(patch_.vertices[i]) = x.row(static_cast<Eigen::Index>(i));
  }

  Points current() const {
    Points x(static_cast<Eigen::Index>(patch_.vertices.size()), 3);
    for (std::size_t i = 0; i < patch_.vertices.size(); ++i)
      x.row(static_cast<Eigen::Index>(i)) = positions_.row(patch_.vertices[i]);
    return x;
  }

  Energy minimise(double epsilon);

  const TetMesh& rest_;
  Patch patch_;
  Points& positions_;
  std::vector<Index> slot_;  // #V: row of a free vertex, −1 for the others
};

struct Step {
  Points move, change;  // of position and of gradient
  double rho;
};

// L-BFGS two-loop recursion: −H g.
Points descent_direction(const Points& gradient, const std::deque<Step>& history) {
  const auto dot = [](const Points& a, const Points& b) { return a.cwiseProduct(b).sum(); };
  Points d = -gradient;
  std::vector<double> alpha(history.size());
  for (std::size_t i = history.size(); i-- > 0;) {
    alpha[i] = history[i].rho * dot(history[i].move, d);
    d -= alpha[i] * history[i].change;
  }
  if (!history.empty())
    d *= dot(history.back().move, history.back().change) / history.back().change.squaredNorm();
  for (std::size_t i = 0; i < history.size(); ++i)
    d += (alpha[i] - history[i].rho * dot(history[i].change, d)) * history[i].move;
  return d;
}

// L-BFGS with backtracking, for a fixed ε.
Energy Unfolder::minimise(double epsilon) {
  constexpr int kSteps = 60, kMemory = 8, kHalvings = 40;
  Points x = current(), gradient, next_gradient;
  Energy now = evaluate(epsilon, &gradient);
  const double edge = mean_edge_length(rest_);
  std::deque<Step> history;
  for (int step = 0; step < kSteps; ++step) {
    Points direction = descent_direction(gradient, history);
    double slope = direction.cwiseProduct(gradient).sum();
    const double largest = direction.rowwise().norm().maxCoeff();
    if (!(slope < 0) || largest < 1e-12 * edge) break;
    double length = history.empty() ? std::min(1.0, 0.1 * edge / largest) : 1.0;
    Energy next;
    int halving = 0;
    for (;; ++halving, length *= 0.5) {
      if (halving == kHalvings) {
        move_to(x);
        return now;
      }
      move_to(x + length * direction);
      next = evaluate(epsilon, nullptr);
      if (next.value <= now.value + 1e-4 * length * slope) break;
    }
    next = evaluate(epsilon, &next_gradient);
    Step taken{length * direction, next_gradient - gradient, 0};
    const double curvature = taken.move.cwiseProduct(taken.change).sum();
    const double decrease = now.value - next.value;
    x += taken.move;
    gradient = next_gradient;
    now = next;
    if (curvature > 0) {
      taken.rho = 1 / curvature;
      history.push_back(std::move(taken));
      if (history.size() > kMemory) history.pop_front();
    }
    if (decrease < 1e-6 * now.value) break;
  }
  return now;
}

struct Freedom {
  std::vector<char> fixed_z;                       // #V
  std::vector<std::vector<Index>> tets_of_vertex;  // #V
};

Freedom make_freedom(const TetMesh& rest, const std::vector<char>& on_plate) {
  Freedom freedom{on_plate, std::vector<std::vector<Index>>(on_plate.size())};
  for (Index t = 0; t < rest.tet_count(); ++t) {
    int low = 0;
    for (int i = 0; i < 4; ++i) {
      freedom.tets_of_vertex[rest.tets(t, i)].push_back(t);
      low += on_plate[rest.tets(t, i)] != 0;
    }
    // With all corners at z = 0 it could never get a volume.
    if (low == 4)
      for (int i = 0; i < 4; ++i) freedom.fixed_z[rest.tets(t, i)] = 0;
  }
  return freedom;
}

// The vertices within `rings` edges of the folded tets, with the tets around them; ascending.
Patch make_patch(const TetMesh& rest, const Freedom& freedom, const std::vector<Index>& folded,
                 int rings) {
  std::vector<char> free(static_cast<std::size_t>(rest.vertex_count()), 0),
      touched(static_cast<std::size_t>(rest.tet_count()), 0);
  for (const Index t : folded)
    for (int i = 0; i < 4; ++i) free[rest.tets(t, i)] = 1;
  const auto mark_tets = [&] {
    for (Index v = 0; v < rest.vertex_count(); ++v)
      if (free[v])
        for (const Index t : freedom.tets_of_vertex[v]) touched[t] = 1;
  };
  for (int ring = 0; ring < rings; ++ring) {
    mark_tets();
    for (Index t = 0; t < rest.tet_count(); ++t)
      if (touched[t])
        for (int i = 0; i < 4; ++i) free[rest.tets(t, i)] = 1;
  }
  mark_tets();
  Patch patch;
  for (Index v = 0; v < rest.vertex_count(); ++v) {
    if (!free[v]) continue;
    patch.vertices.push_back(v);
    patch.fixed_z.push_back(freedom.fixed_z[v]);
  }
  double volume = 0;
  for (Index t = 0; t < rest.tet_count(); ++t) {
    if (!touched[t]) continue;
    patch.tets.push_back(t);
    patch.gradients.push_back(hat_gradients(rest, t));
    patch.weight.push_back(tet_volume(rest.vertices, rest.tets, t));
    volume += patch.weight.back();
  }
  for (double& weight : patch.weight) weight *= static_cast<double>(patch.tets.size()) / volume;
  return patch;
}

std::vector<Index> folded_tets(const TetMesh& rest, const Points& deformed) {
  std::vector<Index> folded;
  const Values share = volume_shares(rest, deformed);
  for (Index t = 0; t < rest.tet_count(); ++t)
    if (!(share(t) > kLeastVolumeShare)) folded.push_back(t);
  return folded;
}

// The largest share of the deformation, in steps of a fifth, that leaves no tet folded. Share 0 is
// the rest shape.
double blend_towards_rest(const TetMesh& rest, Points& deformed) {
  const Points full = deformed;
  double share = 1;
  while (!folded_tets(rest, deformed).empty()) {
    share = share > 1e-3 ? 0.8 * share : 0;
    deformed = share * full + (1 - share) * rest.vertices;
    if (share == 0) break;
  }
  return share;
}

}  // namespace

Values volume_shares(const TetMesh& rest, const Points& deformed) {
  Values share(rest.tet_count());
  for (Index t = 0; t < rest.tet_count(); ++t)
    share(t) = tet_volume(deformed, rest.tets, t) / tet_volume(rest.vertices, rest.tets, t);
  return share;
}

FoldoverReport repair_foldovers(const TetMesh& rest, const std::vector<char>& vertex_on_plate,
                                Points& deformed, Context& ctx) {
  FoldoverReport report;
  std::vector<Index> folded = folded_tets(rest, deformed);
  report.found = static_cast<Index>(folded.size());
  if (folded.empty()) return report;
  const Points before = deformed;
  const Freedom freedom = make_freedom(rest, vertex_on_plate);
  for (int rings = 1; !folded.empty(); rings *= 2) {
    Patch patch = make_patch(rest, freedom, folded, rings);
    const bool whole = patch.tets.size() == static_cast<std::size_t>(rest.tet_count());
    Points attempt = deformed;
    Unfolder(rest, std::move(patch), attempt).run(ctx);
    const std::vector<Index> left = folded_tets(rest, attempt);
    // A patch that failed may have tangled its surroundings; start the larger one from where this
    // one did.
    if (left.size() < folded.size()) {
      deformed = attempt;
      folded = left;
    }
    if (whole) break;
  }
  if (!folded.empty()) {
    report.kept_share = blend_towards_rest(rest, deformed);
    std::vector<Vec3> places;
    for (std::size_t i = 0; i < std::min<std::size_t>(folded.size(), 100); ++i)
      places.push_back(rest.centroid(folded[i]));
    ctx.warn("deformation.blended",
             "The deformed shape folds over itself in " + std::to_string(folded.size()) +
                 " tets that could not be unfolded; " +
                 std::to_string(static_cast<int>(100 * report.kept_share)) +
                 " % of the deformation are kept. A finer mesh or weaker objectives may help.",
             std::move(places));
  }
  for (Index v = 0; v < rest.vertex_count(); ++v)
    report.moved_vertices += deformed.row(v) != before.row(v);
  return report;
}

}  // namespace s3
