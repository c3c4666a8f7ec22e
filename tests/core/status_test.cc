// SPDX-License-Identifier: BSD-3-Clause

#include "core/status.h"

#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

namespace freegs {
namespace {

TEST(StatusTest, OkByDefault) {
  const Status status;
  EXPECT_TRUE(status.ok());
  EXPECT_EQ(status.code(), StatusCode::kOk);
  EXPECT_TRUE(status.Annotated("context").message().empty());
}

TEST(StatusTest, AnnotationKeepsTheCode) {
  const Status status = BadInputError("a.jpg: empty").Annotated("ingest");
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_EQ(status.message(), "ingest: a.jpg: empty");
}

TEST(StatusTest, EachMakerHasItsCode) {
  EXPECT_EQ(InvalidArgumentError("").code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(UnusableResultError("").code(), StatusCode::kUnusableResult);
  EXPECT_EQ(MissingDependencyError("").code(), StatusCode::kMissingDependency);
  EXPECT_EQ(InterruptedError("").code(), StatusCode::kInterrupted);
  EXPECT_EQ(InternalError("").code(), StatusCode::kInternal);
}

TEST(StatusOrTest, ValueOrError) {
  StatusOr<std::string> value = std::string("x");
  ASSERT_TRUE(value.ok());
  EXPECT_TRUE(value.status().ok());
  EXPECT_EQ(value->size(), 1u);
  const StatusOr<std::string> error = InternalError("no");
  EXPECT_FALSE(error.ok());
  EXPECT_EQ(error.status().message(), "no");
}

// The macros, with a type that can only be moved.
StatusOr<std::unique_ptr<int>> Half(int n) {
  if (n % 2 != 0) return InvalidArgumentError("odd");
  return std::make_unique<int>(n / 2);
}

StatusOr<int> Quarter(int n) {
  FREEGS_ASSIGN_OR_RETURN(const std::unique_ptr<int> half, Half(n));
  std::unique_ptr<int> quarter;
  FREEGS_ASSIGN_OR_RETURN(quarter, Half(*half));
  return *quarter;
}

Status IsMultipleOfFour(int n) {
  FREEGS_RETURN_IF_ERROR(Quarter(n).status());
  return Status();
}

TEST(StatusMacrosTest, LeaveWithTheFirstError) {
  EXPECT_EQ(*Quarter(12), 3);
  EXPECT_EQ(Quarter(6).status().message(), "odd");
  EXPECT_TRUE(IsMultipleOfFour(8).ok());
  EXPECT_EQ(IsMultipleOfFour(7).code(), StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace freegs
