// SPDX-License-Identifier: BSD-3-Clause
// Times HDBSCAN on a file of points and prints the figures as CSV.
//
//   freegs_hdbscan_benchmark POINTS.f32 DIM [--labels OUT.i32] ...
//
// POINTS.f32: raw little-endian floats, row by row. --rows and --columns take a
// part of them.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>
#include <sys/resource.h>
#include <vector>

#include <boost/program_options.hpp>

#include "core/io/byte_stream.h"
#include "core/io/files.h"
#include "core/parallel.h"
#include "semantics/hdbscan/hdbscan.h"
#include "semantics/metrics/adjusted_rand_index.h"

namespace freegs::semantics {
namespace {

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) +
           1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

struct Points {
  std::vector<float> values;
  int dim = 0;
};

// The first columns of every step-th row, so that `rows` remain (0 = all).
StatusOr<Points> ReadPoints(const std::string& path,
                            int dim,
                            size_t rows,
                            int columns) {
  FREEGS_ASSIGN_OR_RETURN(const auto bytes, ReadFile(path));
  std::vector<float> all;
  ByteReader(bytes).GetArray(bytes.size() / sizeof(float), &all);
  if (dim < 1 || all.size() % dim != 0) {
    return InvalidArgumentError(path + ": not a whole number of points");
  }
  const size_t count = all.size() / dim;
  if (rows == 0 || rows > count) rows = count;
  Points points;
  points.dim = columns < 1 ? dim : std::min(columns, dim);
  for (size_t i = 0; i < rows; ++i) {
    const float* row = all.data() + i * count / rows * dim;
    points.values.insert(points.values.end(), row, row + points.dim);
  }
  return points;
}

// Prints a row; the least of `repeats` times. Returns the labels.
StatusOr<std::vector<int32_t>> Measure(const Points& points,
                                       const HdbscanOptions& options,
                                       int repeats,
                                       ThreadPool& pool) {
  double wall = 1e30;
  double cpu = 1e30;
  HdbscanResult result;
  for (int i = 0; i < repeats; ++i) {
    const double cpu_begin = CpuSeconds();
    const auto begin = std::chrono::steady_clock::now();
    FREEGS_ASSIGN_OR_RETURN(
        result, Hdbscan(points.values, points.dim, options, pool, nullptr));
    const std::chrono::duration<double> taken =
        std::chrono::steady_clock::now() - begin;
    wall = std::min(wall, taken.count());
    cpu = std::min(cpu, CpuSeconds() - cpu_begin);
  }
  std::printf("%zu,%d,%d,%d,%.4f,%.4f,%.12g,%d,%td\n",
              result.labels.size(),
              points.dim,
              options.min_samples,
              pool.num_threads(),
              wall,
              cpu,
              result.mst_weight,
              result.num_clusters,
              std::count(result.labels.begin(), result.labels.end(), -1));
  std::fflush(stdout);
  return std::move(result.labels);
}

Status Run(const boost::program_options::variables_map& arguments) {
  FREEGS_ASSIGN_OR_RETURN(const Points points,
                          ReadPoints(arguments["points"].as<std::string>(),
                                     arguments["dim"].as<int>(),
                                     arguments["rows"].as<size_t>(),
                                     arguments["columns"].as<int>()));
  ThreadPool pool(arguments["threads"].as<int>());
  const int size = arguments["size"].as<int>();
  const int repeats = std::max(1, arguments["repeats"].as<int>());
  const HdbscanOptions options{.min_cluster_size = size, .min_samples = size};
  std::printf(
      "points,dim,min_samples,threads,seconds,cpu_seconds,mst_weight,clusters,"
      "noise\n");
  FREEGS_ASSIGN_OR_RETURN(const std::vector<int32_t> labels,
                          Measure(points, options, repeats, pool));
  if (arguments.count("labels") != 0) {
    const std::string bytes(reinterpret_cast<const char*>(labels.data()),
                            labels.size() * sizeof(int32_t));
    FREEGS_RETURN_IF_ERROR(
        WriteFileAtomic(arguments["labels"].as<std::string>(), bytes));
  }
  return {};
}

}  // namespace
}  // namespace freegs::semantics

int main(int argc, char** argv) {
  namespace po = boost::program_options;
  po::options_description options("freegs_hdbscan_benchmark POINTS.f32 DIM");
  auto add = options.add_options();
  add("points", po::value<std::string>()->required(), "raw floats");
  add("dim", po::value<int>()->required(), "columns of the file");
  add("size",
      po::value<int>()->default_value(20),
      "min_cluster_size and min_samples");
  add("threads", po::value<int>()->default_value(2), "threads");
  add("repeats", po::value<int>()->default_value(1), "least time of as many");
  add("rows", po::value<size_t>()->default_value(0), "points to take, 0 = all");
  add("columns", po::value<int>()->default_value(0), "columns, 0 = all");
  add("labels", po::value<std::string>(), "write the labels here");
  po::positional_options_description positional;
  positional.add("points", 1).add("dim", 1);
  po::variables_map arguments;
  try {
    po::store(po::command_line_parser(argc, argv)
                  .options(options)
                  .positional(positional)
                  .run(),
              arguments);
    po::notify(arguments);
  } catch (const po::error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  const freegs::Status status = freegs::semantics::Run(arguments);
  if (status.ok()) return 0;
  std::fprintf(stderr, "%s\n", status.message().c_str());
  return 1;
}
