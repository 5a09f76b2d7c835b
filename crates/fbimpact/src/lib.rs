//! The fbimpact program as a library: command line, scenario, setup, run, results.
