// Goal: a certificate of our own making is one that TLS takes, known by its fingerprint; what is no
// certificate, or another's key, is told.
// Method: certificates that are made here; that a server with one is trusted by it is tested with
// connections (common/rpc, tls_test.cpp).
#include "common/access/certificates.h"

#include <gtest/gtest.h>

#include "common/base/error.h"

namespace sleight::access {
namespace {

TEST(CertificatesTest, OfOurOwnMaking) {
  const Keypair one = make_self_signed();
  const Keypair other = make_self_signed();
  EXPECT_NO_THROW(check_keypair(one));
  EXPECT_TRUE(is_self_signed(one.certificate));
  const std::string fingerprint = fingerprint_of(one.certificate);
  EXPECT_TRUE(fingerprint.starts_with("SHA256:"));
  EXPECT_EQ(fingerprint.size(), 7U + 64U);
  EXPECT_EQ(fingerprint, fingerprint_of(one.certificate + other.certificate));
  EXPECT_NE(fingerprint, fingerprint_of(other.certificate));
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
