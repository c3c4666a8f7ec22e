// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip_export/onnx_graph.h"

#include <climits>
#include <onnx/onnx_pb.h>
#include <utility>

#include "core/io/files.h"

namespace freegs::semantics {
namespace {

constexpr int kIrVersion = 7;
constexpr int kOperatorSet = 13;

template <typename T>
void SetTensor(const std::vector<int64_t>& shape,
               const std::vector<T>& values,
               int type,
               onnx::TensorProto* tensor) {
  tensor->set_data_type(type);
  for (const int64_t side : shape) tensor->add_dims(side);
  tensor->set_raw_data(values.data(), values.size() * sizeof(T));
}

void SetType(const std::string& name,
             const std::vector<int64_t>& shape,
             onnx::ValueInfoProto* value) {
  value->set_name(name);
  onnx::TypeProto::Tensor* type = value->mutable_type()->mutable_tensor_type();
  type->set_elem_type(onnx::TensorProto::FLOAT);
  for (const int64_t side : shape) {
    type->mutable_shape()->add_dim()->set_dim_value(side);
  }
}

void AddIntegers(const char* name,
                 const std::vector<int64_t>& values,
                 onnx::NodeProto* node) {
  onnx::AttributeProto* attribute = node->add_attribute();
  attribute->set_name(name);
  attribute->set_type(onnx::AttributeProto::INTS);
  for (const int64_t value : values) attribute->add_ints(value);
}

void AddInteger(const char* name, int64_t value, onnx::NodeProto* node) {
  onnx::AttributeProto* attribute = node->add_attribute();
  attribute->set_name(name);
  attribute->set_type(onnx::AttributeProto::INT);
  attribute->set_i(value);
}

onnx::TensorProto* AddConstant(const std::string& name,
                               onnx::GraphProto* graph) {
  onnx::NodeProto* node = graph->add_node();
  node->set_op_type("Constant");
  node->set_name(name);
  node->add_output(name);
  onnx::AttributeProto* attribute = node->add_attribute();
  attribute->set_name("value");
  attribute->set_type(onnx::AttributeProto::TENSOR);
  return attribute->mutable_t();
}

}  // namespace

struct OnnxGraph::Model {
  onnx::ModelProto proto;

  onnx::GraphProto& graph() { return *proto.mutable_graph(); }
  onnx::NodeProto* last_node() {
    return graph().mutable_node(graph().node_size() - 1);
  }
};

OnnxGraph::OnnxGraph() : model_(std::make_unique<Model>()) {
  model_->proto.set_ir_version(kIrVersion);
  model_->proto.set_producer_name("freegs_pipeline");
  model_->proto.add_opset_import()->set_version(kOperatorSet);
  model_->graph().set_name("clip");
}

OnnxGraph::~OnnxGraph() = default;
OnnxGraph::OnnxGraph(OnnxGraph&& other) noexcept = default;
OnnxGraph& OnnxGraph::operator=(OnnxGraph&& other) noexcept = default;

OnnxValue OnnxGraph::NewName(const std::string& kind) {
  return kind + "_" + std::to_string(num_names_++);
}

OnnxValue OnnxGraph::Input(const Shape& shape) {
  SetType("input", shape, model_->graph().add_input());
  return "input";
}

void OnnxGraph::Output(const OnnxValue& value, const Shape& shape) {
  SetType(value, shape, model_->graph().add_output());
}

OnnxValue OnnxGraph::Node(const std::string& op,
                          const std::vector<OnnxValue>& inputs) {
  onnx::NodeProto* node = model_->graph().add_node();
  const OnnxValue name = NewName(op);
  node->set_op_type(op);
  node->set_name(name);
  for (const OnnxValue& input : inputs) node->add_input(input);
  node->add_output(name);
  return name;
}

OnnxValue OnnxGraph::Convolution(const OnnxValue& x, ConvolutionLayer layer) {
  std::vector<OnnxValue> inputs = {x, Weights(layer.shape, layer.weight)};
  if (!layer.bias.empty()) {
    inputs.push_back(
        Weights({static_cast<int64_t>(layer.bias.size())}, layer.bias));
  }
  const OnnxValue y = Node("Conv", inputs);
  onnx::NodeProto* node = model_->last_node();
  const Shape kernel = {layer.shape[2], layer.shape[3]};
  AddIntegers("dilations", {1, 1}, node);
  AddInteger("group", layer.groups, node);
  AddIntegers("kernel_shape", kernel, node);
  AddIntegers("pads", {0, 0, 0, 0}, node);
  AddIntegers("strides", kernel, node);
  return y;
}

OnnxValue OnnxGraph::Reshape(const OnnxValue& x, const Shape& shape) {
  return Node("Reshape", {x, Integers(shape)});
}

OnnxValue OnnxGraph::Transpose(const OnnxValue& x, const Shape& order) {
  const OnnxValue y = Node("Transpose", {x});
  AddIntegers("perm", order, model_->last_node());
  return y;
}

OnnxValue OnnxGraph::Slice(const OnnxValue& x,
                           int axis,
                           int64_t begin,
                           int64_t end) {
  const OnnxValue from = Integers({begin});
  const OnnxValue to = Integers({end});
  const OnnxValue along = Integers({axis});
  return Node("Slice", {x, from, to, along, Integers({1})});
}

OnnxValue OnnxGraph::Concat(const std::vector<OnnxValue>& inputs, int axis) {
  const OnnxValue y = Node("Concat", inputs);
  AddInteger("axis", axis, model_->last_node());
  return y;
}

OnnxValue OnnxGraph::SoftmaxOfLast(const OnnxValue& x) {
  const OnnxValue y = Node("Softmax", {x});
  AddInteger("axis", -1, model_->last_node());
  return y;
}

OnnxValue OnnxGraph::InstanceNorm(const OnnxValue& x,
                                  int channels,
                                  double epsilon) {
  const auto count = static_cast<size_t>(channels);
  const auto constant = [&](float value) {
    const OnnxValue name = NewName("Constant");
    SetTensor({channels},
              std::vector<float>(count, value),
              onnx::TensorProto::FLOAT,
              AddConstant(name, &model_->graph()));
    return name;
  };
  const OnnxValue gain = constant(1);
  const OnnxValue offset = constant(0);
  const OnnxValue y = Node("InstanceNormalization", {x, gain, offset});
  onnx::AttributeProto* attribute = model_->last_node()->add_attribute();
  attribute->set_name("epsilon");
  attribute->set_type(onnx::AttributeProto::FLOAT);
  attribute->set_f(static_cast<float>(epsilon));
  return y;
}

OnnxValue OnnxGraph::Weights(const Shape& shape,
                             const std::vector<float>& values) {
  const OnnxValue name = NewName("weights");
  onnx::TensorProto* tensor = model_->graph().add_initializer();
  tensor->set_name(name);
  SetTensor(shape, values, onnx::TensorProto::FLOAT, tensor);
  return name;
}

OnnxValue OnnxGraph::Number(float value) {
  const OnnxValue name = NewName("Constant");
  SetTensor({},
            std::vector<float>{value},
            onnx::TensorProto::FLOAT,
            AddConstant(name, &model_->graph()));
  return name;
}

OnnxValue OnnxGraph::Integers(const Shape& values) {
  const OnnxValue name = NewName("Constant");
  SetTensor({static_cast<int64_t>(values.size())},
            values,
            onnx::TensorProto::INT64,
            AddConstant(name, &model_->graph()));
  return name;
}

Status OnnxGraph::Write(const std::filesystem::path& path) const {
  std::string content;
  if (model_->proto.ByteSizeLong() > INT_MAX ||
      !model_->proto.SerializeToString(&content)) {
    return MissingDependencyError(
        path.string() +
        ": the network is larger than the 2 GB that an ONNX file can hold; "
        "take a smaller model");
  }
  return WriteFileAtomic(path, content);
}

}  // namespace freegs::semantics
