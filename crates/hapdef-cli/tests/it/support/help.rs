//! Every command's help has an example that the command line takes; for the tests of all programs.

use clap::{Command, CommandFactory, Parser};

/// Checks the help of the program `C` and of all its commands. Examples begin with `name` as it is typed;
/// what follows a pipe is another program's.
pub fn every_help_has_an_example_that_is_understood<C: Parser + CommandFactory>(name: &str) {
    check::<C>(&mut C::command(), name);
}

fn check<C: Parser>(command: &mut Command, name: &str) {
    let help = command.render_long_help().to_string();
    assert!(help.contains("Example"), "{}", command.get_name());
    for example in help.lines().map(str::trim) {
        let Some(rest) = example.strip_prefix(name).filter(|rest| rest.starts_with(' ')) else {
            continue;
        };
        let words = rest.split_whitespace().take_while(|word| *word != "|");
        let parsed = C::try_parse_from(std::iter::once(name).chain(words));
        assert!(parsed.is_ok(), "{example}: {:?}", parsed.err());
    }
    let own = |sub: &&mut Command| sub.get_name() != "help";
    let subcommands = command.get_subcommands_mut().filter(own);
    subcommands.for_each(|sub| check::<C>(sub, name));
}
