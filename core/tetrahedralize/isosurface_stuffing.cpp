#include "tetrahedralize/isosurface_stuffing.h"

namespace s3 {

TetMesh fill_by_stuffing(const TriMesh&, int, Context&) {
  throw Error(ErrorKind::slicing, Stage::tetrahedralize, "tetrahedralize.unavailable",
              "This version has no mesher for surfaces that are not the border of a solid",
              "Repair the surface in your CAD program");
}

}  // namespace s3
