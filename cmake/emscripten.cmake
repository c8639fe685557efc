# What a build with em++ (Emscripten 3.1.6) needs; included where EMSCRIPTEN is set.

# Single-threaded with WebAssembly's own exceptions. (With -pthread these are never caught: that build needs
# -fexceptions.)
add_compile_options(-fwasm-exceptions -msimd128)
add_link_options(-fwasm-exceptions -sALLOW_MEMORY_GROWTH -sINITIAL_MEMORY=256MB -sMAXIMUM_MEMORY=4GB
  -sTOTAL_STACK=8MB)
add_library(Threads::Threads INTERFACE IMPORTED)

# The header-only libraries of the system, and nothing else of its headers.
set(Eigen3_DIR /usr/share/eigen3/cmake CACHE PATH "Eigen's CMake package")
set(S3_HEADER_PREFIX /usr/include CACHE PATH "Where the folders doctest and nlohmann are")
set(s3_headers ${PROJECT_BINARY_DIR}/headers)
file(MAKE_DIRECTORY ${s3_headers})
foreach(library doctest nlohmann)
  if(NOT IS_DIRECTORY ${S3_HEADER_PREFIX}/${library})
    message(FATAL_ERROR "${S3_HEADER_PREFIX}/${library} is missing: `./dev build` installs it, or set S3_HEADER_PREFIX")
  endif()
  file(CREATE_LINK ${S3_HEADER_PREFIX}/${library} ${s3_headers}/${library} SYMBOLIC)
endforeach()
include_directories(SYSTEM ${s3_headers})
