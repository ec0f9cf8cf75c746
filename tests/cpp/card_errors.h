// What tests of cards that fail have in common.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <initializer_list>
#include <string>

#include "omma/error.h"

namespace omma::test {

constexpr int out_of_memory = 2, launch_failed = 719;  // CUresult

inline std::string error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

inline void expect_words(const std::string& message, std::initializer_list<const char*> words) {
  for (const char* const word : words)
    EXPECT_NE(message.find(word), std::string::npos) << word << " in: " << message;
}

}  // namespace omma::test
