# What a build with em++ (Emscripten 3.1.6) needs; included where EMSCRIPTEN is set.

option(S3_WASM_THREADS "WebAssembly: build with threads (pthreads over SharedArrayBuffer)" OFF)

# No -msimd128: clang 14 then vectorises straight code wrongly (-fno-slp-vectorize hides it), and models were placed askew.
add_compile_options(-fwasm-exceptions)
add_link_options(-fwasm-exceptions -sALLOW_MEMORY_GROWTH -sMAXIMUM_MEMORY=4GB -sTOTAL_STACK=8MB)
if(S3_WASM_THREADS)
  add_compile_options(-pthread "$<$<COMPILE_LANGUAGE:CXX>:SHELL:-include ${CMAKE_CURRENT_LIST_DIR}/emscripten/thread_exceptions.h>")
  add_link_options(-pthread -Wno-pthreads-mem-growth)
endif()
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
