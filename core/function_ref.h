// SPDX-License-Identifier: BSD-3-Clause
// A reference to a callable object, for functions that only call it before they
// return. Unlike std::function it never allocates memory.

#ifndef FREEGS_CORE_FUNCTION_REF_H_
#define FREEGS_CORE_FUNCTION_REF_H_

#include <memory>
#include <type_traits>
#include <utility>

namespace freegs {

template <typename Signature>
class FunctionRef;

// The callable must live longer than the reference. A lambda that is passed as
// an argument does: ForEachPixel([&](int x, int y) { ... }).
template <typename Result, typename... Arguments>
class FunctionRef<Result(Arguments...)> {
 public:
  template <typename Callable>
  requires(!std::is_same_v<std::remove_cvref_t<Callable>, FunctionRef>)
      FunctionRef(Callable&& callable)  // NOLINT: converts like std::function.
      : object_(const_cast<void*>(
            static_cast<const void*>(std::addressof(callable)))),
        call_([](void* object, Arguments... arguments) -> Result {
          return (*static_cast<std::remove_reference_t<Callable>*>(object))(
              std::forward<Arguments>(arguments)...);
        }) {}

  Result operator()(Arguments... arguments) const {
    return call_(object_, std::forward<Arguments>(arguments)...);
  }

 private:
  void* object_;
  Result (*call_)(void*, Arguments...);
};

}  // namespace freegs

#endif  // FREEGS_CORE_FUNCTION_REF_H_
