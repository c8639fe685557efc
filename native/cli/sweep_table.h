// The files of a sweep: sweep.csv, sweep.json and sweep.svg.
#pragma once
#include <string>
#include <vector>

#include "metrics/metrics.h"
#include "pipeline/pipeline.h"
#include "weight_triples.h"

namespace s3::cli {

struct SweepRow {
  WeightTriple weights;
  Metrics metrics;     // what was not computed is empty
  std::string error;   // why it did not come to its end; empty where it did
  double cpu_seconds;  // of all threads
  std::vector<Warning> warnings;
};

struct SweepTable {
  std::string model_file;
  std::size_t asked = 0;       // triples
  std::vector<SweepRow> rows;  // those that have ended, in order
  Metrics planar;              // of planar layers; no Π, which depends on the weights
  std::string planar_error;    // why it has no strain, where it was asked for
  double shared_cpu_seconds = 0, planar_cpu_seconds = 0;
};

/// One line a triple, after one for the planar layers. What was not computed is empty.
std::string sweep_csv(const SweepTable& table);

/// The same with the mesh, the effective configuration, warnings and CPU seconds of what the
/// triples share. Weights of the configuration are those of the last triple.
std::string sweep_json(const SweepTable& table, const Pipeline& pipeline);

/// A triangle for each figure that some row has: Π, SF, SR, SQ, strain.
std::string sweep_svg(const SweepTable& table);

/// The table that a sweep ends with.
std::string sweep_text(const SweepTable& table);

/// "SF 0.7 SR 0.3 SQ 0".
std::string name_of(const WeightTriple& weights);

}  // namespace s3::cli
