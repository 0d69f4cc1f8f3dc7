-- What wrk sends and says: a POST of a file's bytes (or a GET), and the figures as one line of JSON.
-- usage: wrk ... -s post.lua URL -- BODY-FILE|- [ACCEPT]
function init(args)
   wrk.headers["Host"] = "localhost"
   if args[2] then wrk.headers["Accept"] = args[2] end
   if args[1] == "-" then return end
   local file = assert(io.open(args[1], "rb"))
   wrk.method = "POST"
   wrk.headers["Content-Type"] = "application/json"
   wrk.body = file:read("*a")
   file:close()
end

function done(summary, latency, requests)
   local e = summary.errors
   io.write(string.format(
      '\nfigures {"requests":%d,"seconds":%.6f,"bytes":%d,"p50":%.4f,"p99":%.4f,"longest":%.4f,"errors":%d,"late":%d}\n',
      summary.requests, summary.duration / 1e6, summary.bytes, latency:percentile(50) / 1e3, latency:percentile(99) / 1e3,
      latency.max / 1e3, e.connect + e.read + e.write + e.status, e.timeout))
end
