// Included before every file of TetGen (cmake/tetgen.cmake): makes the library quiet, repeatable,
// unable to abort and able to be cancelled. The C headers come first, because the definitions below
// replace what they define.
#pragma once
#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "hooks.h"

// A failed self-check ends like TetGen's other internal errors: with the exception 2.
#undef assert
#define assert(condition) ((condition) ? (void)0 : throw 2)

#define printf(...) ((void)0)

// TetGen's functions hold pools that an exception would leave behind.
#define malloc(bytes) s3::tetgen::allocate(bytes)
#define free(block) s3::tetgen::release(block)

// The C library's generators differ between platforms; every use in TetGen sets the seed first.
static unsigned long long s3_tetgen_random_state = 1;
static inline void s3_tetgen_srand(unsigned seed) {
  s3_tetgen_random_state = seed;
}
static inline int s3_tetgen_rand() {
  s3_tetgen_random_state = s3_tetgen_random_state * 6364136223846793005ULL + 1442695040888963407ULL;
  return static_cast<int>(s3_tetgen_random_state >> 33);
}
#define srand s3_tetgen_srand
#define rand s3_tetgen_rand
