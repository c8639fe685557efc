// The kinds of SpdSolver, each in its own file: make_solver() chooses. Not for callers.
#pragma once
#include <memory>

#include "math/sparse_solver.h"

namespace s3 {

/// Square, symmetric, finite, positive diagonal. Costs one pass over the entries.
/// @throws Error "solver.not_spd", naming the row
void check_spd(const SparseMatrix& A);

/// The sizes that solve() asks for.
/// @throws Error "solver.bad_size"
void check_sizes(Eigen::Index rows, const Block& B, const Block& X);

/// ‖b − A x‖ / ‖b‖ of the worst column; columns with b = 0 do not count.
double worst_residual(const SparseMatrix& A, const Block& B, const Block& X);

std::unique_ptr<SpdSolver> make_conjugate_gradient_solver(const SolverOptions& options);
std::unique_ptr<SpdSolver> make_ldlt_solver();
#ifdef S3_WITH_CHOLMOD
std::unique_ptr<SpdSolver> make_cholmod_solver();
#endif

}  // namespace s3
