// Goal: Sleight makes valid certificates, and each has its own fingerprint. A text that isn't a
// certificate is refused. A key that belongs to another certificate is refused. Method: make
// certificates and read them back. The test common/rpc/tls_test.cpp makes connections with such
// certificates.
#include "common/access/certificates.h"

#include <gtest/gtest.h>

#include "common/base/error.h"

namespace sleight::access {
namespace {

TEST(CertificatesTest, OfOurOwnMaking) {
  const Keypair one = make_self_signed();
  const Keypair other = make_self_signed();
  EXPECT_NO_THROW(check_keypair(one));
  EXPECT_EQ(self_signed_name(one.certificate), k_self_name);
  EXPECT_TRUE(is_valid_now(one.certificate));
  const std::string fingerprint = fingerprint_of(one.certificate);
  EXPECT_TRUE(fingerprint.starts_with("SHA256:"));
  EXPECT_EQ(fingerprint.size(), 7U + 64U);
  EXPECT_EQ(fingerprint, fingerprint_of(one.certificate + other.certificate));
  EXPECT_NE(fingerprint, fingerprint_of(other.certificate));
}

TEST(CertificatesTest, EachOfABundle) {
  const Keypair one = make_self_signed();
  const Keypair other = make_self_signed();
  const auto found =
      certificates_in("# ours\n" + one.certificate + "\nwords between\n" + other.certificate);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(fingerprint_of(found[0]), fingerprint_of(one.certificate));
  EXPECT_EQ(fingerprint_of(found[1]), fingerprint_of(other.certificate));
  EXPECT_TRUE(certificates_in("").empty());
  EXPECT_TRUE(certificates_in(one.key).empty());
}

TEST(CertificatesTest, WhatIsNoneIsTold) {
  const Keypair one = make_self_signed();
  const Keypair other = make_self_signed();
  EXPECT_THROW(check_keypair({.certificate = one.certificate, .key = other.key}), base::Error);
  EXPECT_THROW(check_keypair({.certificate = one.certificate, .key = "no key"}), base::Error);
  EXPECT_THROW(check_keypair({.certificate = one.key, .key = one.key}), base::Error);
  EXPECT_THROW(static_cast<void>(fingerprint_of("")), base::Error);
  EXPECT_THROW(static_cast<void>(fingerprint_of(one.certificate.substr(0, 100))), base::Error);
}

}  // namespace
}  // namespace sleight::access
