// SPDX-License-Identifier: BSD-3-Clause
// Looks at an ONNX file before OpenCV reads it, whose importer (seen in 4.6)
// believes what a file says and crashes when that is wrong.

#ifndef FREEGS_SEMANTICS_CLIP_NETWORK_CHECK_H_
#define FREEGS_SEMANTICS_CLIP_NETWORK_CHECK_H_

#include <string>

namespace freegs::semantics {

// Returns what is wrong with the content of an ONNX file; empty when nothing
// is. It is held against the ONNX standard by ONNX's own checker: every node
// has the inputs and attributes of its operator, and every input exists. Beyond
// that, tensors must have as many values as their dimensions say, in the file
// itself.
std::string FaultOfNetwork(const std::string& content);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_NETWORK_CHECK_H_
