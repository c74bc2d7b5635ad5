// The part of Asio's TLS that no template needs, compiled once.
#include <boost/asio/ssl/impl/src.hpp>
