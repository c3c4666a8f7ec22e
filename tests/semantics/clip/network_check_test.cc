// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/network_check.h"

#include <onnx/onnx_pb.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/semantics/clip/model_files.h"
#include "tests/temporary_folder.h"

namespace freegs::semantics {
namespace {

using testing::HasSubstr;

// One node "Add" of the input and a constant of two numbers.
onnx::ModelProto AddModel() {
  onnx::ModelProto model;
  model.set_ir_version(8);
  model.add_opset_import()->set_version(13);
  onnx::GraphProto* const graph = model.mutable_graph();
  graph->set_name("graph");
  for (onnx::ValueInfoProto* const value :
       {graph->add_input(), graph->add_output()}) {
    auto* const type = value->mutable_type()->mutable_tensor_type();
    type->set_elem_type(onnx::TensorProto::FLOAT);
    type->mutable_shape()->add_dim()->set_dim_value(2);
  }
  graph->mutable_input(0)->set_name("x");
  graph->mutable_output(0)->set_name("y");
  onnx::TensorProto* const constant = graph->add_initializer();
  constant->set_name("c");
  constant->set_data_type(onnx::TensorProto::FLOAT);
  constant->add_dims(2);
  constant->set_raw_data(std::string(8, '\0'));
  onnx::NodeProto* const node = graph->add_node();
  node->set_op_type("Add");
  node->add_input("x");
  node->add_input("c");
  node->add_output("y");
  return model;
}

std::string FaultOf(const onnx::ModelProto& model) {
  return FaultOfNetwork(model.SerializeAsString());
}

TEST(NetworkCheckTest, GoodNetworks) {
  EXPECT_EQ(FaultOf(AddModel()), "");
  for (const char* name : {"visual.onnx", "text.onnx"}) {
    EXPECT_EQ(FaultOfNetwork(ReadText(TinyClip() / name)), "") << name;
  }
}

TEST(NetworkCheckTest, WhatOpenCvWouldBelieve) {
  EXPECT_EQ(FaultOfNetwork("no network"), "not an ONNX file");
  EXPECT_THAT(FaultOfNetwork(""), HasSubstr("not valid ONNX"));

  onnx::ModelProto model = AddModel();
  model.mutable_graph()->mutable_node(0)->mutable_input()->RemoveLast();
  EXPECT_THAT(FaultOf(model), HasSubstr("not valid ONNX"));

  model = AddModel();
  model.mutable_graph()->mutable_node(0)->set_input(1, "nobody");
  EXPECT_THAT(FaultOf(model), HasSubstr("not valid ONNX"));

  for (const int64_t dim : {int64_t{3}, int64_t{1}, int64_t{1} << 40}) {
    model = AddModel();
    model.mutable_graph()->mutable_initializer(0)->set_dims(0, dim);
    EXPECT_THAT(FaultOf(model), HasSubstr("dimensions")) << dim;
  }
  model = AddModel();
  onnx::TensorProto* const constant =
      model.mutable_graph()->mutable_initializer(0);
  constant->set_dims(0, int64_t{1} << 31);
  constant->add_dims(int64_t{1} << 31);
  constant->add_dims(4);  // The product overflows to 0.
  constant->set_raw_data("");
  EXPECT_NE(FaultOf(model), "");

  model = AddModel();
  model.mutable_graph()->mutable_initializer(0)->set_data_type(
      onnx::TensorProto::STRING);
  EXPECT_NE(FaultOf(model), "");
}

}  // namespace
}  // namespace freegs::semantics
