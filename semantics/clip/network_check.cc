// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/network_check.h"

#include <cstdint>
#include <exception>
#include <onnx/checker.h>
#include <onnx/onnx_pb.h>

namespace freegs::semantics {
namespace {

using onnx::TensorProto;

// The bytes of a value in raw_data; 0 for types that OpenCV does not read.
uint64_t RawSize(int type) {
  switch (type) {
    case TensorProto::FLOAT:
    case TensorProto::INT32:
      return 4;
    case TensorProto::DOUBLE:
    case TensorProto::INT64:
      return 8;
    case TensorProto::FLOAT16:
      return 2;
    case TensorProto::INT8:
    case TensorProto::UINT8:
    case TensorProto::BOOL:
      return 1;
    default:
      return 0;
  }
}

uint64_t NumValues(const TensorProto& tensor) {
  if (tensor.has_raw_data()) {
    const uint64_t size = RawSize(tensor.data_type());
    const uint64_t bytes = tensor.raw_data().size();
    return bytes % size == 0 ? bytes / size : UINT64_MAX;
  }
  switch (tensor.data_type()) {
    case TensorProto::FLOAT:
      return static_cast<uint64_t>(tensor.float_data_size());
    case TensorProto::DOUBLE:
      return static_cast<uint64_t>(tensor.double_data_size());
    case TensorProto::INT64:
      return static_cast<uint64_t>(tensor.int64_data_size());
    default:
      return static_cast<uint64_t>(tensor.int32_data_size());
  }
}

std::string FaultOfTensor(const TensorProto& tensor) {
  const std::string name = "tensor \"" + tensor.name() + "\" ";
  if (RawSize(tensor.data_type()) == 0) return name + "is of an unknown type";
  if (tensor.data_location() == TensorProto::EXTERNAL) {
    return name + "is in another file";
  }
  const uint64_t values = NumValues(tensor);
  uint64_t expected = 1;
  for (const int64_t dim : tensor.dims()) {
    // So the product of dimensions that are right does not overflow.
    if (dim < 0 || (dim > 0 && expected > UINT32_MAX) || dim > UINT32_MAX) {
      return name + "has dimensions that cannot be";
    }
    expected *= static_cast<uint64_t>(dim);
  }
  if (values == expected) return "";
  return name + "has other dimensions than values";
}

std::string FaultOfGraph(const onnx::GraphProto& graph) {
  for (const TensorProto& tensor : graph.initializer()) {
    const std::string fault = FaultOfTensor(tensor);
    if (!fault.empty()) return fault;
  }
  for (const onnx::NodeProto& node : graph.node()) {
    for (const onnx::AttributeProto& attribute : node.attribute()) {
      std::string fault;
      if (attribute.has_t()) fault = FaultOfTensor(attribute.t());
      if (attribute.has_g() && fault.empty()) {
        fault = FaultOfGraph(attribute.g());
      }
      if (!fault.empty()) return fault;
    }
  }
  return "";
}

}  // namespace

std::string FaultOfNetwork(const std::string& content) {
  onnx::ModelProto model;
  if (!model.ParseFromString(content)) return "not an ONNX file";
  try {
    onnx::checker::check_model(model);
  } catch (const std::exception& error) {
    const std::string text = error.what();
    return "not valid ONNX: " + text.substr(0, text.find('\n'));
  }
  return FaultOfGraph(model.graph());
}

}  // namespace freegs::semantics
