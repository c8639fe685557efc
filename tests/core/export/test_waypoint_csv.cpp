#include <doctest/doctest.h>

#include <string>

#include "base/error.h"
#include "export/number_text.h"
#include "export/waypoint_csv.h"
#include "layer_shapes.h"
#include "toolpaths/make_toolpaths.h"
#include "waypoints/make_waypoints.h"

using namespace s3;

TEST_CASE("numbers are rounded and keep their sign") {
  const auto text = [](double value, int decimals) {
    std::string s;
    append_fixed(s, value, decimals);
    return s;
  };
  CHECK(text(1.23456, 3) == "1.235");
  CHECK(text(-0.05, 1) == "-0.1");
  CHECK(text(-0.0001, 2) == "0.00");
  CHECK(text(12, 0) == "12");
  CHECK(text(99.9996, 3) == "100.000");
}

TEST_CASE("waypoints survive their text form") {
  Context ctx;
  LayerStack stack;
  stack.layers = {test::make_cap(12, 6, 0.7), test::make_lobes(0.7)};
  stack.layers[1].layer = 7;
  const Waypoints w = make_waypoints(stack, make_toolpaths(stack, nullptr, {}, 1.0, ctx), {}, ctx);
  const Waypoints back = read_waypoint_csv(write_waypoint_csv(w));
  REQUIRE(back.size() == w.size());
  REQUIRE(w.size() > 100);
  CHECK((back.position - w.position).cwiseAbs().maxCoeff() < 1e-5);
  CHECK((back.normal - w.normal).cwiseAbs().maxCoeff() < 1e-6);
  CHECK((back.tangent - w.tangent).cwiseAbs().maxCoeff() < 1e-6);
  CHECK((back.width - w.width).cwiseAbs().maxCoeff() < 1e-4);
  CHECK((back.height - w.height).cwiseAbs().maxCoeff() < 1e-4);
  CHECK((back.extrusion - w.extrusion).cwiseAbs().maxCoeff() < 1e-6);
  CHECK((back.speed - w.speed).cwiseAbs().maxCoeff() < 1e-3);
  CHECK(back.layer == w.layer);
  CHECK(back.path == w.path);
  CHECK(back.kind == w.kind);
  CHECK(back.travel == w.travel);
}

TEST_CASE("a waypoint file with a wrong line is refused with the line's number") {
  const std::string header =
      "layer,path,kind,x,y,z,nx,ny,nz,tx,ty,tz,width,height,e,speed,travel\n";
  const std::string good = "0,0,wall,1,2,3,0,0,1,1,0,0,0.4,0.2,0.01,20,0\n";
  CHECK(read_waypoint_csv(header + good).size() == 1);
  CHECK(read_waypoint_csv("# a\r\n" + header + good).size() == 1);
  const std::string bad[] = {"",
                             good,
                             header + "0,0,wall,1,2\n",
                             header + "0,0,wall,1,2,3,0,0,1,1,0,0,0.4,0.2,0.01,20,0,9\n",
                             header + "0,0,wall,x,2,3,0,0,1,1,0,0,0.4,0.2,0.01,20,0\n",
                             header + "0,0,wall,nan,2,3,0,0,1,1,0,0,0.4,0.2,0.01,20,0\n",
                             header + "0,0,wall,1e999,2,3,0,0,1,1,0,0,0.4,0.2,0.01,20,0\n",
                             header + "0.5,0,wall,1,2,3,0,0,1,1,0,0,0.4,0.2,0.01,20,0\n",
                             header + "0,0,roof,1,2,3,0,0,1,1,0,0,0.4,0.2,0.01,20,0\n",
                             header + "0,0,wall,1,2,3,0,0,1,1,0,0,0.4,0.2,0.01,20,2\n",
                             header + "99999999999,0,wall,1,2,3,0,0,1,1,0,0,0.4,0.2,0.01,20,0\n",
                             header + std::string(100000, ',')};
  for (const std::string& text : bad) {
    CAPTURE(text.substr(0, 200));
    CHECK_THROWS_AS(read_waypoint_csv(text), Error);
  }
}
