// The part of the libraries that no template needs, compiled once.
#include <boost/asio/impl/src.hpp>
#include <boost/beast/src.hpp>
