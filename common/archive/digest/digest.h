// The digest of an archive: one hash of its content in logical order, the same for every storage.
//
// It is the SHA-256 of a manifest, a text with one line for each object:
//
//   sleight-archive digest 1
//   group /posterior
//   attribute /posterior thin i64 10
//   attribute /posterior/x units text <SHA-256 of the text>
//   dataset /posterior/x f64 chain=4,draw=101 <SHA-256 of the values>
//
// Lines after the first are sorted as bytes. A double attribute is its 16 hexadecimal digits. The
// values of a dataset are hashed in row-major order: f64, i64 and i32 as little-endian bytes, every
// NaN as 0x7ff8000000000000, a boolean as its byte, text as its length (8 bytes) and its bytes.
// Hence the digest knows nothing of chunks, compression, creation order or NaN payloads.
//
// Left out: the root attributes content_digest, inference_library_version, results_version and
// run_id (format.h).
// Two manifests that differ name the object in which the archives differ.
#pragma once

#include <functional>
#include <string>

#include "common/archive/model.h"

namespace sleight::archive {

/// Reads everything, in batches. Thread-safe as far as the source is.
std::string manifest(const Source& source);
/// 64 hexadecimal digits.
std::string digest(const Source& source);

/// Lets `fill` write an archive into `sink` through a checker of model.h's invariants, computes the
/// digest on the way, adds it as the root attribute content_digest, finishes the sink and returns
/// the digest. REQUIRES: `fill` does not call finish.
std::string write_digested(Sink& sink, const std::function<void(Sink&)>& fill);

}  // namespace sleight::archive
