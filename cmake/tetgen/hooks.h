// What TetGen's patched source calls, defined in core/tetrahedralize/tetgen_backend.cpp: memory
// that a run which ends by an exception gives back, and the question whether to go on.
#pragma once
#include <stddef.h>

namespace s3 {
namespace tetgen {

/// @throws int 1, TetGen's code for "out of memory"
void* allocate(size_t bytes);
void release(void* block);

/// Called in the loops that take long.
/// @throws s3::Cancelled
void checkpoint();

}  // namespace tetgen
}  // namespace s3
