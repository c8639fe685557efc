// The stages of the pipeline in their order. A folder of core is named after each; the order is
// also the rule for includes: a stage may include earlier stages only (tests/check_includes.mjs).
#pragma once
#include <string_view>

namespace s3 {

enum class Stage {
  mesh,              // input, validation, placement           Sec. 2
  tetrahedralize,    //                                         Sec. 2
  fea,               // stress field, own or imported           Sec. 2.1.2
  objectives,        // feasible regions                        Sec. 2.1, 3.1
  quaternion_field,  //                                         Sec. 3.2, 3.3
  deformation,       // Eq. 12                                  Sec. 4.1
  scalar_field,      // G, refinement                           Sec. 4.1, 4.2
  outer_loop,        // both methods, Eq. 13                    Sec. 4.1
  layers,            // adaptive slicing                        Sec. 4.2
  toolpaths,         //                                         Sec. 5.1
  waypoints,         //                                         Sec. 5.1
  motion,            // machines                                Sec. 5.1
  exporting,         // folder `export`; the word itself is reserved in C++
  metrics,           //                                         Sec. 5.2
};

/// The stage's stable text form, as used in parameter keys, error messages and progress.
std::string_view stage_name(Stage stage);

}  // namespace s3
