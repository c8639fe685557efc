# TetGen 1.5.0 (Hang Si, AGPL-3+) as a static library, from the source that cmake/fetch_tetgen.sh gets from Debian.
# As shipped it crashes on surfaces that touch or intersect themselves: it frees its memory, throws, and the destructor
# frees again. The copy in the build tree is patched to throw an int instead; cmake/tetgen/guard.h does the rest.

if(DEFINED ENV{S3_TETGEN_DIR})
  set(s3_tetgen_default $ENV{S3_TETGEN_DIR})
else()
  set(s3_tetgen_default ${PROJECT_SOURCE_DIR}/build/tetgen)
endif()
set(S3_TETGEN_DIR ${s3_tetgen_default} CACHE PATH "Folder with the source of TetGen 1.5.0")

if(NOT EXISTS ${S3_TETGEN_DIR}/tetgen.cxx)
  message(STATUS "Fetching the source of TetGen into ${S3_TETGEN_DIR}")
  execute_process(COMMAND ${CMAKE_CURRENT_LIST_DIR}/fetch_tetgen.sh ${S3_TETGEN_DIR} RESULT_VARIABLE s3_fetch_result)
endif()
if(NOT EXISTS ${S3_TETGEN_DIR}/tetgen.cxx)
  message(FATAL_ERROR "The source of TetGen is missing in ${S3_TETGEN_DIR}. `./dev build` fetches it from Debian's "
    "archive; -DS3_TETGEN_DIR=… names a copy of your own; -DS3_WITH_TETGEN=OFF builds without it (volume meshes only).")
endif()

# Replaces `old` by `new` in the variable named `text`; an error where `old` is missing.
function(s3_patch text old new)
  string(FIND "${${text}}" "${old}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "${S3_TETGEN_DIR} is not the source of TetGen 1.5.0: cannot find\n${old}")
  endif()
  string(REPLACE "${old}" "${new}" patched "${${text}}")
  set(${text} "${patched}" PARENT_SCOPE)
endfunction()

set(s3_tetgen_copy ${PROJECT_BINARY_DIR}/tetgen-patched)
file(READ ${S3_TETGEN_DIR}/tetgen.h s3_tetgen_header)
s3_patch(s3_tetgen_header "  if (m) {\n    m->freememory();\n  }\n#ifdef TETLIBRARY\n"
                          "  (void) m; // its destructor frees the memory\n#ifdef TETLIBRARY\n")
s3_patch(s3_tetgen_header "#include <assert.h>" "// assert comes from guard.h")
file(CONFIGURE OUTPUT ${s3_tetgen_copy}/tetgen.h CONTENT "${s3_tetgen_header}" @ONLY)
configure_file(${S3_TETGEN_DIR}/tetgen.cxx ${s3_tetgen_copy}/tetgen.cxx COPYONLY)
configure_file(${S3_TETGEN_DIR}/predicates.cxx ${s3_tetgen_copy}/predicates.cxx COPYONLY)

set(s3_tetgen_guard ${CMAKE_CURRENT_LIST_DIR}/tetgen/guard.h)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${s3_tetgen_guard})
add_library(tetgen STATIC ${s3_tetgen_copy}/tetgen.cxx ${s3_tetgen_copy}/predicates.cxx)
set_target_properties(tetgen PROPERTIES CXX_STANDARD 14 EXPORT_COMPILE_COMMANDS OFF)
set_source_files_properties(${s3_tetgen_copy}/tetgen.cxx ${s3_tetgen_copy}/predicates.cxx
  TARGET_DIRECTORY tetgen PROPERTIES OBJECT_DEPENDS ${s3_tetgen_guard})
target_compile_definitions(tetgen PUBLIC TETLIBRARY)
target_include_directories(tetgen SYSTEM PUBLIC ${s3_tetgen_copy})
# The exact predicates need plain double arithmetic: no contraction whatever the target offers.
target_compile_options(tetgen PRIVATE -w -include ${s3_tetgen_guard} -fno-strict-aliasing -ffp-contract=off
  $<$<BOOL:${S3_MARCH}>:-march=${S3_MARCH}>)
if(S3_SANITIZE)
  target_compile_options(tetgen PRIVATE -fsanitize=${S3_SANITIZE} -fno-sanitize-recover=all)
endif()
