// Conjugate gradients for a few right-hand sides at once, preconditioned in single precision.
#pragma once
#include "base/context.h"
#include "math/sparse_solver.h"

namespace s3 {

/// Right-hand sides that one pass over the matrix serves; more are solved in groups.
inline constexpr int kMaxColumns = 4;

/// A cheap stand-in for A⁻¹: a symmetric positive definite linear map, the same one in every call.
class Preconditioner {
 public:
  virtual ~Preconditioner() = default;

  /// z ≈ A⁻¹ r up to a positive factor. Both n×columns, row-major; columns in [1, kMaxColumns].
  /// May use scratch memory of the object: one call at a time.
  virtual void apply(const float* r, float* z, int columns, ThreadPool& pool) const = 0;
};

/// Solves A X = B until ‖b − A x‖ ≤ tolerance·‖b‖ in every column, or max_iterations. X is the warm
/// start on entry. The answer does not depend on the number of threads.
/// @throws Error "solver.not_spd" when a search direction p has pᵀAp < 0
SolveReport conjugate_gradient(const SparseMatrix& A, const Preconditioner& preconditioner,
                               const Block& B, Block& X, double tolerance, int max_iterations,
                               Context& ctx);

}  // namespace s3
