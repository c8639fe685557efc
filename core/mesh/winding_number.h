// How often a surface winds around a point: inside and outside of any triangles, closed or not
// (Jacobson, Kavan, Sorkine-Hornung 2013), fast by a tree of expansions (Barill et al. 2018).
#pragma once
#include <array>
#include <vector>

#include "base/types.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// The generalized winding number of triangles: the sum of their signed solid angles over 4π.
///
/// 1 inside a closed surface that faces outward, 0 outside and in a cavity (an inverted shell
/// inside a body), 2 where two bodies overlap, −1 inside a body that is inside out. Holes, gaps and
/// doubled sheets make it a smooth fraction: "inside" is w > 1/2, which closes holes with a smooth
/// sheet and ignores faces that lie within a body. It follows the triangles' orientation and does
/// not mend it: triangles must be turned consistently before.
/// Building takes O(n log n) time and about 260 bytes per triangle; the mesh is not referenced
/// afterwards. Queries are const and may run on many threads; they take about O(log n) time.
class WindingNumber {
 public:
  WindingNumber() = default;
  /// @param mesh  indices in range, coordinates finite; triangles without area are welcome
  explicit WindingNumber(const TriMesh& mesh);

  /// @param p  mm; on the surface itself the value is one of those around it
  /// @return within about 0.01 of exact()
  double at(const Vec3& p) const;

  /// The plain sum over all triangles, O(n).
  double exact(const Vec3& p) const;

  /// Inside the solid that the triangles bound.
  bool is_inside(const Vec3& p) const { return at(p) > 0.5; }

 private:
  struct Face {
    Vec3 a, b, c;
  };
  // Moments of a node's triangles about its centre: of w's integral, expanded to second order.
  struct Node {
    Vec3 center = Vec3::Zero();
    double radius = 0;              // of the ball about `center` that holds the triangles
    Vec3 dipole = Vec3::Zero();     // ∫ n
    std::array<double, 6> first{};  // ∫ n⊗d, symmetric part: xx yy zz yz zx xy
    std::array<double, 10> second{};  // ∫ n⊗d⊗d, symmetric part: xxx yyy zzz xxy xxz yyx yyz zzx
                                      // zzy xyz
    Index begin = 0, end = 0;            // faces
    std::array<Index, 2> child{-1, -1};  // −1: a leaf
  };

  Index build(std::size_t begin, std::size_t end);
  void expand(Node& node) const;
  static double far_field(const Node& node, const Vec3& p);

  std::vector<Face> faces_;  // leaf by leaf
  std::vector<Node> nodes_;  // the root is the first
};

}  // namespace s3
