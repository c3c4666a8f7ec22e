// SPDX-License-Identifier: BSD-3-Clause
// Builds a network and writes it as an ONNX file.

#ifndef FREEGS_SEMANTICS_CLIP_EXPORT_ONNX_GRAPH_H_
#define FREEGS_SEMANTICS_CLIP_EXPORT_ONNX_GRAPH_H_

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/status.h"

namespace freegs::semantics {

// A network from one input to one output, node by node:
//
//   OnnxGraph graph;
//   const OnnxValue x = graph.Input({1, 3, 224, 224});
//   const OnnxValue y = graph.Node("Sigmoid", {graph.Convolution(x, ...)});
//   graph.Output(y, {1, 512, 14, 14});
//   FREEGS_RETURN_IF_ERROR(graph.Write(folder / "a.onnx"));
//
// The operators are those of operator set 13, and shapes are literal. Nothing
// is checked but the size of the file; the tests let OpenCV run what is built.
class OnnxGraph {
 public:
  // The name of a value in the graph.
  using OnnxValue = std::string;
  using Shape = std::vector<int64_t>;

  struct ConvolutionLayer {
    Shape shape;  // Shape of the weight: out x in / groups x h x w.
    std::vector<float> weight;
    std::vector<float> bias;  // Or empty.
    int groups = 1;
  };

  OnnxGraph();
  ~OnnxGraph();
  OnnxGraph(OnnxGraph&& other) noexcept;
  OnnxGraph& operator=(OnnxGraph&& other) noexcept;

  OnnxValue Input(const Shape& shape);
  void Output(const OnnxValue& value, const Shape& shape);

  // A node without attributes. Returns its output.
  OnnxValue Node(const std::string& op, const std::vector<OnnxValue>& inputs);

  // A convolution without padding; the stride is the size of the kernel.
  OnnxValue Convolution(const OnnxValue& x, ConvolutionLayer layer);

  // A side of -1 is what is left.
  OnnxValue Reshape(const OnnxValue& x, const Shape& shape);
  OnnxValue Transpose(const OnnxValue& x, const Shape& order);
  OnnxValue Slice(const OnnxValue& x, int axis, int64_t begin, int64_t end);
  OnnxValue Concat(const std::vector<OnnxValue>& inputs, int axis);
  OnnxValue SoftmaxOfLast(const OnnxValue& x);

  // B x channels x n: each channel to mean 0 and variance 1 over its n numbers.
  OnnxValue InstanceNorm(const OnnxValue& x, int channels, double epsilon);

  // A tensor of weights, and a single number.
  OnnxValue Weights(const Shape& shape, const std::vector<float>& values);
  OnnxValue Number(float value);

  // kMissingDependency if the network is larger than the 2 GB that an ONNX file
  // can hold; else the errors of WriteFileAtomic.
  Status Write(const std::filesystem::path& path) const;

 private:
  struct Model;  // Keeps the headers of ONNX out of this one.

  OnnxValue NewName(const std::string& kind);
  OnnxValue Integers(const Shape& values);

  std::unique_ptr<Model> model_;
  int num_names_ = 0;
};

using OnnxValue = OnnxGraph::OnnxValue;

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_EXPORT_ONNX_GRAPH_H_
