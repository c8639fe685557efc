#include "toolpaths/toolpaths.h"

namespace s3 {

const char* path_kind_name(PathKind kind) {
  switch (kind) {
    case PathKind::wall:
      return "wall";
    case PathKind::infill:
      return "infill";
    case PathKind::gap_fill:
      return "gap_fill";
  }
  return "wall";
}

}  // namespace s3
