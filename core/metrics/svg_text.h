// Numbers and sentences as they stand in SVG text.
#pragma once
#include <string>

namespace s3 {

/// Shortest text of a number with at most three digits behind the point.
std::string svg_number(double value);

/// A sentence with & and < escaped.
std::string svg_escaped(const std::string& text);

}  // namespace s3
