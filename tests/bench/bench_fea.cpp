// Times the stress analysis on a bent bar of about TETS tets, stage by stage. One JSON object a
// line.
//   s3bench_fea [--tets N] [--threads N] [--cases N]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <string>

#include <sys/resource.h>

#include "core/grid_mesh.h"
#include "fea/linear_elasticity.h"
#include "fea/stress.h"
#include "mesh/reorder.h"

using namespace s3;

namespace {

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// A shaken bar of 4×2×1 that is bent by a quarter turn, so that no two tets are alike.
TetMesh bent_bar(int tets) {
  const int n = std::max(1, static_cast<int>(std::lround(std::cbrt(tets / 48.0))));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> shift(-0.2, 0.2);
  return reorder_along_morton(
      test::make_grid(4 * n, 2 * n, n, Vec3(4 * n, 2 * n, n), [&](const Vec3& p) {
        const Vec3 q =
            p + (p.z() > 0.5 ? 1.0 : 0.0) * Vec3(shift(random), shift(random), shift(random));
        const double angle = 1.5 * q.x() / (4 * n), radius = 3 * n - q.z();
        return Vec3(Vec3(radius * std::sin(angle), q.y(), 3 * n - radius * std::cos(angle)) * 20.0 /
                    n);
      }));
}

/// Held at one end, pulled at the other in a few directions.
LoadCases cases_of(const TetMesh& mesh, int count) {
  LoadCases file;
  file.material = bundled_materials().front();
  const Vec3 high = mesh.vertices.colwise().maxCoeff().transpose();
  file.regions = {{"start", {HalfSpace{{0.6, 0, 0}, {-1, 0, 0}}}},
                  {"end", {HalfSpace{{0, 0, high.z() - 0.6}, {0, 0, 1}}}}};
  for (int c = 0; c < count; ++c)
    file.cases.push_back(
        {"pull", {{0, Displacement{{0.0, 0.0, 0.0}}}, {1, TotalForce{Vec3(c, 1, -2)}}}});
  return file;
}

}  // namespace

int main(int argc, char** argv) {
  int tets = 200000, threads = 1, cases = 1;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string word = argv[i];
    const int value = std::max(1, std::atoi(argv[i + 1]));
    if (word == "--tets") tets = value;
    if (word == "--threads") threads = value;
    if (word == "--cases") cases = value;
  }
  const TetMesh mesh = bent_bar(tets);
  const LoadCases file = cases_of(mesh, cases);
  Context ctx(threads);
  const double memory_before = peak_memory_mb(), start = cpu_seconds();
  const auto loadings = apply_load_cases(mesh, file, ctx);
  const double applied = cpu_seconds();
  ElasticBody body{isotropic_stiffness(file.material.young, file.material.poisson), {}};
  const auto displacements = solve_elasticity(mesh, body, loadings, {}, ctx);
  const double solved = cpu_seconds();
  for (const Points& u : displacements)
    stress_field(stresses(body, strains(mesh, u, ctx), ctx), ctx);
  const double done = cpu_seconds();
  body.stiffness = orthotropic_stiffness(file.material.printed);
  body.frame.assign(static_cast<std::size_t>(mesh.tet_count()), Mat3::Identity());
  solve_elasticity(mesh, body, loadings, {}, ctx);
  const double orthotropic = cpu_seconds() - done;
  std::printf(
      "{\"bench\": \"fea\", \"tets\": %d, \"unknowns\": %d, \"cases\": %d, \"threads\": %d, "
      "\"load_cpu_s\": %.2f, \"solve_cpu_s\": %.2f, \"stress_cpu_s\": %.2f, \"total_cpu_s\": %.2f, "
      "\"orthotropic_solve_cpu_s\": %.2f, \"peak_memory_mb\": %.0f, \"mesh_memory_mb\": %.0f}\n",
      static_cast<int>(mesh.tet_count()), static_cast<int>(3 * mesh.vertex_count()), cases, threads,
      applied - start, solved - applied, done - solved, done - start, orthotropic, peak_memory_mb(),
      memory_before);
  return 0;
}
