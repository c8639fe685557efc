# SuiteSparse's CHOLMOD as the target s3_cholmod: an oracle for tests and benchmarks, never needed to slice.
# Debian: libsuitesparse-dev.
find_path(S3_CHOLMOD_INCLUDE cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
find_library(S3_CHOLMOD_LIBRARY cholmod REQUIRED)
add_library(s3_cholmod INTERFACE)
target_include_directories(s3_cholmod SYSTEM INTERFACE ${S3_CHOLMOD_INCLUDE})
target_link_libraries(s3_cholmod INTERFACE ${S3_CHOLMOD_LIBRARY})
target_compile_definitions(s3_cholmod INTERFACE S3_WITH_CHOLMOD)
