// Times the solvers on systems like the pipeline's. One JSON object a line.
//   s3bench_solver [--kinds multigrid,ldlt] [--systems blend,refinement,elasticity,grid] [--threads
//   N] [--cells N …] [MODEL.tet …]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "core/grid_mesh.h"
#include "core/test_systems.h"
#include "mesh/read_mesh.h"
#include "mesh/reorder.h"

using namespace s3;

namespace {

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct System {
  std::string name;
  SparseMatrix matrix;
  Block right_hand_side, near_nullspace;
  int block_size = 1;
};

/// A block of cells whose vertices are shaken, so that no two tets are alike.
TetMesh shaken_grid(int cells) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> shift(-0.2, 0.2);
  return reorder_along_morton(test::make_grid(
      cells, cells, cells, Vec3::Constant(cells),
      [&](const Vec3& p) { return Vec3(p + Vec3(shift(random), shift(random), shift(random))); }));
}

TetMesh read_volume(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  ModelFile model = read_model(std::as_bytes(std::span(bytes)), path);
  return reorder_along_morton(make_tet_mesh(std::move(model.vertices), std::move(model.tets)));
}

/// Fields like the pipeline's: smooth, and rough on every 50th row.
Block loads(const SparseMatrix& A, int columns) {
  Block solution = test::random_block(A.rows(), columns);
  for (Eigen::Index i = 0; i < solution.rows(); ++i)
    for (int c = 0; c < columns; ++c)
      solution(i, c) =
          std::sin(6.0 * (c + 1) * static_cast<double>(i) / static_cast<double>(A.rows())) +
          (i % 50 == 0 ? 0.3 * solution(i, c) : 0);
  return A * solution;
}

System make_system(const std::string& name, const TetMesh& mesh) {
  const double low = mesh.vertices.col(2).minCoeff();
  const double middle = low + 0.5 * (mesh.vertices.col(2).maxCoeff() - low);
  System system{name, {}, {}, {}, 1};
  if (name == "blend") {
    system.matrix = test::blend_system(mesh, 1.0, middle);
    system.right_hand_side = loads(system.matrix, 4);
  } else if (name == "refinement") {
    system.matrix = test::refinement_system(mesh, 0.01, 0.3, 0.3);
    system.near_nullspace = test::linear_functions(mesh);
    system.right_hand_side = loads(system.matrix, 1);
  } else if (name == "refinement_constant") {
    system.matrix = test::refinement_system(mesh, 0.01, 0.3, 0.3);
    system.right_hand_side = loads(system.matrix, 1);
  } else if (name == "elasticity") {
    system.matrix = test::elasticity_system(mesh, low + 1e-6);
    system.near_nullspace = test::rigid_body_modes(mesh);
    system.block_size = 3;
    system.right_hand_side = loads(system.matrix, 1);
  } else {
    std::fprintf(stderr, "unknown system %s\n", name.c_str());
    std::exit(2);
  }
  return system;
}

void measure(const std::string& model, const System& system, SolverKind kind, const char* kind_name,
             int threads, double tolerance) {
  Context ctx(threads);
  const auto solver = make_solver({.kind = kind,
                                   .tolerance = tolerance,
                                   .near_nullspace = system.near_nullspace,
                                   .block_size = system.block_size});
  const double start = cpu_seconds();
  solver->factor(system.matrix, ctx);
  const double factored = cpu_seconds();
  solver->factor(system.matrix, ctx);
  const double factored_again = cpu_seconds();
  Block X = Block::Zero(system.matrix.rows(), system.right_hand_side.cols());
  const SolveReport report = solver->solve(system.right_hand_side, X, ctx);
  const double solved = cpu_seconds();
  std::printf(
      "{\"model\": \"%s\", \"system\": \"%s\", \"kind\": \"%s\", \"n\": %d, \"entries\": %d, "
      "\"columns\": %d, "
      "\"threads\": %d, \"setup_cpu_s\": %.3f, \"setup_again_cpu_s\": %.3f, \"solve_cpu_s\": %.3f, "
      "\"iterations\": %d, \"residual\": %.2g}\n",
      model.c_str(), system.name.c_str(), kind_name, static_cast<int>(system.matrix.rows()),
      static_cast<int>(system.matrix.nonZeros()), static_cast<int>(X.cols()), threads,
      factored - start, factored_again - factored, solved - factored_again, report.iterations,
      report.relative_residual);
  std::fflush(stdout);
}

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> words(1);
  for (const char c : list) {
    if (c == ',')
      words.emplace_back();
    else
      words.back() += c;
  }
  return words;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> kinds = {"multigrid"}, systems = {"blend", "refinement", "elasticity"};
  std::vector<std::string> models;
  std::vector<int> cells;
  int threads = 1;
  double tolerance = 1e-6;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool has_value = i + 1 < argc;
    if (word == "--kinds" && has_value)
      kinds = split(argv[++i]);
    else if (word == "--systems" && has_value)
      systems = split(argv[++i]);
    else if (word == "--threads" && has_value)
      threads = std::atoi(argv[++i]);
    else if (word == "--tolerance" && has_value)
      tolerance = std::atof(argv[++i]);
    else if (word == "--cells" && has_value)
      cells.push_back(std::atoi(argv[++i]));
    else
      models.push_back(word);
  }
  if (cells.empty() && models.empty()) cells = {16, 24, 32};
  const auto run = [&](const std::string& name, const TetMesh& mesh) {
    for (const std::string& system_name : systems) {
      const System system = make_system(system_name, mesh);
      for (const std::string& kind : kinds) {
        if (kind == "multigrid")
          measure(name, system, SolverKind::multigrid, "multigrid", threads, tolerance);
        if (kind == "jacobi")
          measure(name, system, SolverKind::jacobi, "jacobi", threads, tolerance);
        if (kind == "ldlt") measure(name, system, SolverKind::ldlt, "ldlt", threads, tolerance);
        if (kind == "cholmod")
          measure(name, system, SolverKind::cholmod, "cholmod", threads, tolerance);
      }
    }
  };
  for (const int count : cells) run("grid" + std::to_string(count), shaken_grid(count));
  for (const std::string& path : models)
    run(path.substr(path.find_last_of('/') + 1), read_volume(path));
  return 0;
}
