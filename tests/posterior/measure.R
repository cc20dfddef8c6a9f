# Measures of the arrays in a folder by the package posterior: Rscript measure.R FOLDER.
#
# Writes lines `name measure value margin` to theirs.txt, numbers hexadecimal or NA, and prints the
# package's version. The margin says how firmly an effective sample size stands: the least size of
# a sum of two neighbouring autocorrelations, among those by whose sign posterior ends the series.
# Where it is some 1e-16, the sum is 0 and the rounding of R's Fourier transform has decided.

suppressWarnings(suppressMessages(library(posterior)))

folder <- commandArgs(trailingOnly = TRUE)[1]
probabilities <- c(0, 0.05, 0.25, 0.5, 0.9, 1)

halves <- function(x) posterior:::.split_chains(x)

margin <- function(x) {
  x <- as.matrix(x)
  n <- nrow(x)
  if (n < 3 || posterior:::should_return_NA(x)) return(Inf)
  covariance <- rowMeans(apply(x, 2, posterior:::autocovariance))
  within <- covariance[1] * n / (n - 1)
  total <- covariance[1] + (if (ncol(x) > 1) stats::var(colMeans(x)) else 0)
  rho <- 1 - (within - covariance) / total
  rho[1] <- 1
  least <- Inf
  for (t in seq(0, max(0, n - 4), by = 2)) {
    pair <- rho[t + 1] + rho[t + 2]
    least <- min(least, abs(pair))
    if (is.nan(pair) || pair < -1e-10 || t >= n - 5) break
  }
  least
}

quantile_margin <- function(x, probability) {
  if (posterior:::should_return_NA(x)) return(Inf)
  if (probability == 1) probability <- (length(x) - 0.5) / length(x)
  margin(halves(x <= quantile(x, probability)))
}

measures <- function(x) {
  mean_margin <- margin(halves(x))
  found <- list(
    rhat = c(rhat(x), Inf),
    ess_bulk = c(ess_bulk(x), margin(posterior:::z_scale(halves(x)))),
    ess_tail = c(ess_tail(x), min(quantile_margin(x, 0.05), quantile_margin(x, 0.95))),
    ess_mean = c(ess_mean(x), mean_margin),
    mcse_mean = c(mcse_mean(x), mean_margin)
  )
  for (p in probabilities) {
    at_p <- quantile_margin(x, p)
    found[[paste0("ess_quantile_", p)]] <- c(ess_quantile(x, p, names = FALSE), at_p)
  }
  found
}

arrays <- read.table(file.path(folder, "arrays.txt"), col.names = c("name", "chains", "draws"))
values <- file(file.path(folder, "arrays.bin"), "rb")
out <- file(file.path(folder, "theirs.txt"), "w")
for (i in seq_len(nrow(arrays))) {
  count <- arrays$chains[i] * arrays$draws[i]
  x <- matrix(readBin(values, "double", count, endian = "little"), ncol = arrays$chains[i])
  found <- suppressWarnings(measures(x))
  for (measure in names(found)) {
    cat(arrays$name[i], measure, sprintf("%a", found[[measure]]), "\n", file = out)
  }
}
close(out)
close(values)
cat(as.character(packageVersion("posterior")), "\n")
