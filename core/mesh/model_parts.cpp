#include "mesh/model_parts.h"

#include <numeric>

#include "mesh/weld.h"

namespace s3 {

namespace {

// The piece that stands for all that `piece` is joined to.
Index representative(std::vector<Index>& joined_to, Index piece) {
  const auto to = [&](Index p) -> Index& { return joined_to[static_cast<std::size_t>(p)]; };
  while (to(piece) != piece) {
    to(piece) = to(to(piece));
    piece = to(piece);
  }
  return piece;
}

std::vector<Index> joined_pieces(const TriMesh& mesh, const std::vector<Index>& piece_of_triangle,
                                 std::size_t pieces) {
  std::vector<Index> joined_to(pieces);
  std::iota(joined_to.begin(), joined_to.end(), 0);
  Welder welder(static_cast<std::size_t>(mesh.vertices.rows()));
  std::vector<Index> piece_at;  // of each point
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i) {
      const Index piece = piece_of_triangle[static_cast<std::size_t>(f)];
      const auto point =
          static_cast<std::size_t>(welder.add(mesh.vertices.row(mesh.triangles(f, i))));
      if (point == piece_at.size()) piece_at.push_back(piece);
      const Index a = representative(joined_to, piece);
      const Index b = representative(joined_to, piece_at[point]);
      joined_to[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  for (std::size_t p = 0; p < pieces; ++p)
    joined_to[p] = representative(joined_to, static_cast<Index>(p));
  return joined_to;
}

}  // namespace

void set_parts(ModelFile& model, const std::vector<Index>& piece_of_triangle,
               const std::vector<std::string>& piece_names) {
  model.part_names.clear();
  model.part_of_triangle.clear();
  const std::vector<Index> joined_to =
      joined_pieces(model.surface, piece_of_triangle, piece_names.size());
  std::vector<Index> part_of_piece(piece_names.size(), -1);
  for (const Index piece : piece_of_triangle) {
    Index& part =
        part_of_piece[static_cast<std::size_t>(joined_to[static_cast<std::size_t>(piece)])];
    if (part < 0) {
      part = static_cast<Index>(model.part_names.size());
      model.part_names.push_back(piece_names[static_cast<std::size_t>(piece)]);
    }
    model.part_of_triangle.push_back(part);
  }
}

}  // namespace s3
