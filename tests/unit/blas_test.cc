#include "tetraction/core/blas.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace tetraction {
namespace {

constexpr ProcessorFeatures kOld{};
constexpr ProcessorFeatures kAvx2{true, false};
constexpr ProcessorFeatures kAvx512{true, true};

std::string warning(const char* core, const ProcessorFeatures& processor, const char* asked = "") {
  return blas_warning({"OpenBLAS", core}, processor, asked);
}

bool mentions(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(BlasWarning, OfAnotherLibraryNamesItAndWhatToDo) {
  const std::string text = blas_warning({"/usr/lib/blas/libblas.so.3", ""}, kOld, "");
  for (const char* part : {"/usr/lib/blas/libblas.so.3", "scripts/setup", "update-alternatives"}) {
    EXPECT_TRUE(mentions(text, part)) << text;
  }
  EXPECT_FALSE(blas_warning({"unknown", ""}, kAvx512, "").empty());
}

TEST(BlasWarning, NoneWhereTheKernelsFitTheProcessor) {
  for (const char* core : {"Haswell", "Zen", "ZEN", "Excavator", "SkylakeX", "Cooperlake"}) {
    EXPECT_EQ(warning(core, kAvx2), "") << core;
  }
  for (const char* core : {"SkylakeX", "Cooperlake", "Sapphirerapids", "neoversen1", ""}) {
    EXPECT_EQ(warning(core, kAvx512), "") << core;
    EXPECT_EQ(warning(core, kAvx512, core), "") << core << " asked for";
  }
  for (const char* core : {"Prescott", "Nehalem", "Sandybridge"}) {
    EXPECT_EQ(warning(core, kOld), "") << core << " on a processor without AVX2";
  }
}

TEST(BlasWarning, KernelsWithoutAvx2OnAProcessorThatHasIt) {
  for (const char* core : {"Prescott", "Nehalem", "Sandybridge", "SANDYBRIDGE"}) {
    for (const ProcessorFeatures& processor : {kAvx2, kAvx512}) {
      const std::string own = warning(core, processor);
      EXPECT_TRUE(mentions(own, core)) << own;
      EXPECT_TRUE(mentions(own, "newer OpenBLAS")) << own;
      const std::string asked = warning(core, processor, core);
      EXPECT_TRUE(mentions(asked, std::string("OPENBLAS_CORETYPE=") + core)) << asked;
      EXPECT_TRUE(mentions(asked, "Unset it")) << asked;
    }
  }
}

TEST(BlasWarning, KernelsWithoutAvx512OnlyWhereTheyWereAskedFor) {
  for (const char* core : {"Haswell", "Zen"}) {
    EXPECT_EQ(warning(core, kAvx512), "") << "OpenBLAS' own choice";
    EXPECT_TRUE(mentions(warning(core, kAvx512, core), "AVX-512"));
    EXPECT_EQ(warning(core, kAvx512, "nonsense"), "") << "OpenBLAS ignores it";
    EXPECT_EQ(warning(core, kAvx2, core), "");
  }
  EXPECT_TRUE(mentions(warning("Zen", kAvx512, "ZEN"), "OPENBLAS_CORETYPE=ZEN"));
}

TEST(BlasWarning, OfThisProcessFollowsTheRule) {
  const char* asked = std::getenv("OPENBLAS_CORETYPE");
  EXPECT_EQ(blas_warning(),
            blas_warning(blas_info(), processor_features(), asked != nullptr ? asked : ""));
}

TEST(BlasInfo, OpenBlasIsInUseAfterScriptsSetup) {
  EXPECT_EQ(blas_info().library, "OpenBLAS") << "call scripts/setup";
  EXPECT_FALSE(blas_info().core.empty());
}

}  // namespace
}  // namespace tetraction
