// The digest of an archive: a hash of its content in logical order, independent of the storage.
//
// The digest is the SHA-256 of a manifest, a text with one line per object:
//
//   sleight-archive digest 1
//   group /posterior
//   attribute /posterior thin i64 10
//   attribute /posterior/x units text <SHA-256 of the text>
//   dataset /posterior/x f64 chain=4,draw=101 <SHA-256 of the values>
//
// Lines after the first are sorted as bytes. A double attribute is written as its 16 hexadecimal
// digits. A dataset's values are hashed in row-major order. Values of f64, i64 and i32 are hashed
// as little-endian bytes, and every NaN as 0x7ff8000000000000. A boolean is hashed as its byte, and
// a text as its length (8 bytes) and its bytes. So the digest does not depend on chunks,
// compression, creation order or NaN payloads.
//
// The manifest omits the root attributes content_digest, inference_library_version, results_version
// and run_id (format.h). A comparison of two manifests shows in which objects the archives differ.
#pragma once

#include <functional>
#include <string>

#include "common/archive/model.h"

namespace sleight::archive {

/// Reads the whole archive in batches. As thread-safe as the source.
std::string manifest(const Source& source);
/// Returns 64 hexadecimal digits.
std::string digest(const Source& source);

/// Lets `fill` write an archive into `sink` while checking model.h's invariants. Also computes the
/// digest, adds it as root attribute content_digest, finishes the sink and returns the digest.
/// REQUIRES: `fill` does not call finish.
std::string write_digested(Sink& sink, const std::function<void(Sink&)>& fill);

}  // namespace sleight::archive
