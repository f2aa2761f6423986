# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Make a linear model of a fitted one: `linearize FITTED.yaml`."""

from pathlib import Path

from cdp_ident.command_line import ArgumentParser, entry_point
from cdp_ident.errors import OptionError
from cdp_ident.model.equilibria import EQUILIBRIA
from cdp_ident.output_folder import check_folder, json_text, write_files
from cdp_ident.outside_text import shown
from cdp_ident.start import loading

DESCRIPTION = """\
Make the linear model x' = A x + B u, y = C x + D u of a fitted model about an equilibrium, for the design of a
controller: the state is [x, theta1, theta2, x', theta1', theta2'] (absolute angles), the input the cart's acceleration.
Prints the matrices, how the rods move by themselves, and whether the cart can control them."""

EXAMPLE = """\
example:
  ros2 run cdp_ident linearize identification/one/fitted.yaml --at upright --out upright.json

The file holds A, B, C and D as lists of rows: scipy.signal.StateSpace(*(numpy.array(content[k]) for k in "ABCD")).
docs/how_to/linear_model.md tells what the numbers mean; examples/lqr.py balances a simulated rig with them."""


@entry_point
def main(arguments: list[str]) -> None:
    """Print and write a linear model."""
    parser = ArgumentParser("linearize", DESCRIPTION, EXAMPLE)
    parser.add_argument("fitted", type=Path, metavar="FITTED", help="fitted.yaml of identify, or a file like it")
    parser.add_argument(
        "--at",
        choices=tuple(EQUILIBRIA),
        default="upright",
        help="where the rods rest, the inner one first (upright)",
    )
    parser.add_argument("--out", type=Path, metavar="FILE", help="JSON file to write")
    parser.add_argument("--force", action="store_true", help="replace a file that is there already")
    options = parser.parse_args(arguments)
    if options.out is not None:
        if options.out.is_dir():
            raise OptionError(f"{options.out} is a folder: give --out the name of a file")
        check_folder(options.out.parent, options.force, (options.out.name,))
    with loading("linearize"):
        from cdp_ident.commands._linear_model import linear_model_content, linear_model_lines
        from cdp_ident.configuration.fitted_model import read_fitted_model
        from cdp_ident.model.linear import linearize, without_linear_part
    fitted = read_fitted_model(options.fitted, "linearize")
    effects = fitted.motion.acting(fitted.values, fitted.trial())
    model = linearize(fitted.coefficients, EQUILIBRIA[options.at], effects)
    left_out = without_linear_part(fitted.coefficients, EQUILIBRIA[options.at], effects)
    print(*linear_model_lines(model, options.at, left_out), sep="\n")
    if options.out is not None:
        text = json_text(linear_model_content(model, options.at, left_out))
        write_files(options.out.parent, {options.out.name: text}, force=options.force)
        print(f"written to {shown(options.out)}")
