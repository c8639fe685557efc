# TetGen 1.5.0 (Hang Si, AGPL-3+) as a static library, from the source that cmake/fetch_tetgen.sh gets from Debian.
# As shipped it crashes on surfaces that touch or intersect themselves: it frees its memory, throws, and the destructor
# frees again. The copy in the build tree is patched to throw an int instead, and to ask in its loops whether to go on
# (cmake/tetgen/hooks.h); cmake/tetgen/guard.h does the rest.

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
set(s3_tetgen_own "
    void *operator new(size_t bytes) { return s3::tetgen::allocate(bytes); }
    void operator delete(void *pool) { s3::tetgen::release(pool); }
")
foreach(pool arraypool memorypool)
  s3_patch(s3_tetgen_header "  class ${pool} {\n\n  public:" "  class ${pool} {\n\n  public:\n${s3_tetgen_own}")
endforeach()
file(CONFIGURE OUTPUT ${s3_tetgen_copy}/tetgen.h CONTENT "#include \"hooks.h\"\n${s3_tetgen_header}" @ONLY)

file(READ ${S3_TETGEN_DIR}/tetgen.cxx s3_tetgen_source)
s3_patch(s3_tetgen_source "permutarray = new point[in->numberofpoints];"
                          "permutarray = (point *) malloc(sizeof(point) * in->numberofpoints);")
s3_patch(s3_tetgen_source "delete [] permutarray;" "free(permutarray);")
# Every loop that takes long calls one of these functions, or takes a face from the stack of flips.
foreach(head
  "::locate(point searchpt, \n                                                 triface* searchtet)"
  "::finddirection(triface* searchtet, point endpt)"
  "::recoveredgebyflips(point startpt, point endpt, \n                                   triface* searchtet, int fullsearch)"
  "::recoverfacebyflips(point pa, point pb, point pc, \n                                   face *searchsh, triface* searchtet)"
  "::checkseg4split(face *chkseg, point& encpt, int& qflag)"
  "::checkfac4split(face *chkfac, point& encpt, int& qflag, \n                               REAL *cent)"
  "::checktet4split(triface *chktet, int &qflag, REAL *ccent) "
  "::gettetrahedron(point pa, point pb, point pc, point pd, \n                               triface *searchtet)"
  "::getedge(point e1, point e2, triface *tedge)")
  s3_patch(s3_tetgen_source "${head}\n{" "${head}\n{\n  s3::tetgen::checkpoint();")
endforeach()
s3_patch(s3_tetgen_source "    popface = flipstack;" "    s3::tetgen::checkpoint();\n    popface = flipstack;")
file(CONFIGURE OUTPUT ${s3_tetgen_copy}/tetgen.cxx CONTENT "${s3_tetgen_source}" @ONLY)
configure_file(${S3_TETGEN_DIR}/predicates.cxx ${s3_tetgen_copy}/predicates.cxx COPYONLY)

set(s3_tetgen_guard ${CMAKE_CURRENT_LIST_DIR}/tetgen/guard.h)
set(s3_tetgen_hooks ${CMAKE_CURRENT_LIST_DIR}/tetgen/hooks.h)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${s3_tetgen_guard} ${s3_tetgen_hooks})
add_library(tetgen STATIC ${s3_tetgen_copy}/tetgen.cxx ${s3_tetgen_copy}/predicates.cxx)
set_target_properties(tetgen PROPERTIES CXX_STANDARD 14 EXPORT_COMPILE_COMMANDS OFF)
set_source_files_properties(${s3_tetgen_copy}/tetgen.cxx ${s3_tetgen_copy}/predicates.cxx
  TARGET_DIRECTORY tetgen PROPERTIES OBJECT_DEPENDS "${s3_tetgen_guard};${s3_tetgen_hooks}")
target_compile_definitions(tetgen PUBLIC TETLIBRARY)
target_include_directories(tetgen SYSTEM PUBLIC ${s3_tetgen_copy} ${CMAKE_CURRENT_LIST_DIR}/tetgen)
# The exact predicates need plain double arithmetic: no contraction whatever the target offers.
target_compile_options(tetgen PRIVATE -w -include ${s3_tetgen_guard} -fno-strict-aliasing -ffp-contract=off
  $<$<BOOL:${S3_MARCH}>:-march=${S3_MARCH}>)
if(S3_SANITIZE)
  target_compile_options(tetgen PRIVATE -fsanitize=${S3_SANITIZE} -fno-sanitize-recover=all)
endif()
